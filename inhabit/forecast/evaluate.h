#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "inhabit/forecast/model_file.h"
#include "inhabit/forecast/sample.h"
#include "inhabit/metrics/score_table.h"

namespace inhabit::forecast {

/// Errors of one method in millimetres, as a row of the paper's Tables 1 and 2: at each horizon, then the mean over all
/// future frames.
struct Scores {
  std::string method;
  std::vector<double> path, pose;
};

struct Table {
  std::vector<double> horizons;  ///< seconds: 0.5, 1.0, 1.5, 2.0
  std::vector<Scores> rows;
  int64_t windows = 0;
};

/// The model, its variants without contact points and with the true ones, two baselines (the last pose held; the
/// root at its last velocity with the last pose), and LTD, on every window of `data`.
Table evaluate(const Networks& networks, const Data& data);

/// Laid out as the paper's Tables 1 and 2.
ScoreTable score_table(const Table& table);
std::string table_text(const Table& table);
nlohmann::ordered_json table_json(const Table& table);

}  // namespace inhabit::forecast
