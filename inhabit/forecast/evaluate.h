#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "inhabit/data/measured_parts.h"
#include "inhabit/forecast/model_file.h"
#include "inhabit/forecast/sample.h"
#include "inhabit/metrics/score_table.h"
#include "inhabit/progress.h"

namespace inhabit::forecast {

/// Errors of one method in millimetres, as a row of the paper's Tables 1 and 2: at each horizon, then the mean over all
/// future frames; and what the first frame and the bones say of how the forecast leaves from the person observed.
struct Scores {
  std::string method;        ///< its name in the table
  std::string data;          ///< the name of the data set's folder; empty: all of them together
  std::vector<double> path;  ///< error of the root at each horizon, then the mean
  std::vector<double> pose;  ///< mean error of the joints relative to the root, likewise
  double seam_path = 0;      ///< path error of the first predicted frame
  double seam_pose = 0;      ///< pose error of the first predicted frame
  double bones = 0;          ///< mean difference between bones' lengths and their means in the past
  double bones_most = 0;     ///< the largest of them in any frame
  /// Halves of 95 % intervals by bootstrap over windows: path, pose, seam_path, seam_pose, bones.
  std::vector<double> intervals;
};

/// Errors of all methods.
struct Table {
  std::vector<double> horizons;  ///< seconds: 0.5, 1.0, 1.5, 2.0
  std::vector<Scores> rows;      ///< of all windows; then, where there are several data sets, of each
  int64_t windows = 0;           ///< of all data sets
};

/// The model with predicted contact points, without any and with the true ones, two baselines (the last pose held; the
/// root at its last velocity with the last pose), LTD, HisRep, DMGNN, SLT*, and of a model's hypotheses the likeliest
/// and the best (nearest to the truth by the mean over joints and frames), on every window of `data`. @param progress
/// told how many windows are done; may be empty. @param parts only batches of its shard are measured; without rows,
/// other parts are still to come
Table evaluate(const Networks& networks, const Data& data, const Progress& progress = {},
               const MeasuredParts& parts = {});

/// Laid out as the paper's Tables 1 and 2, with seam and bones behind.
ScoreTable score_table(const Table& table);
/// The table as text, millimetres.
/// @param intervals "+- interval" behind each mean: 95 % by bootstrap over windows
std::string table_text(const Table& table, bool intervals = false);
/// The table as JSON: horizons in seconds, windows, unit and a row each method.
/// @param intervals each number is an object of "mean" and "interval95"
nlohmann::ordered_json table_json(const Table& table, bool intervals = false);

}  // namespace inhabit::forecast
