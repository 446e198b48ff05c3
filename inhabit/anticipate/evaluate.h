#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "inhabit/anticipate/model_file.h"
#include "inhabit/anticipate/sample.h"
#include "inhabit/metrics/score_table.h"

namespace inhabit::anticipate {

/// One method on one action, or over all of them. Curves have a value a horizon; NaN where the recordings end earlier.
struct Scores {
  std::string method;
  std::vector<double> ndms;        ///< Eq. 9 over the words that end in the 0.4 s up to the horizon
  std::vector<double> error;       ///< mm, mean joint error at the horizon, all futures
  std::vector<double> best_error;  ///< mm, of the future nearest to what came true over its known part
  std::vector<double> apd;         ///< metres; deterministic methods have 0
  std::vector<double> root_error;  ///< mm, of the root's place on the ground
  double npss = 0;                 ///< over the known part of 2 to 4 s; NaN where there is none
  double speed_ratio = 0;          ///< mean joint speed of 4 s to the end over that of the real motion
};

struct Table {
  std::vector<double> horizons;  ///< seconds
  int64_t samples = 0;           ///< futures of each observation
  struct Action {
    std::string name;
    int64_t windows = 0, words = 0;  ///< observations, words in the database
    std::vector<Scores> rows;
  };
  std::vector<Action> actions;        ///< then their mean, named "mean"
  std::vector<std::string> left_out;  ///< actions without a test window
};

struct Evaluation {
  int64_t samples = 50;
  int64_t windows = 8;  ///< of each action
  double seconds = 30;  ///< longest horizon
  uint64_t seed = 1;
};

/// The paper's protocol (4, 4.2, 5): futures of every test window scored against the motion words of the test
/// recordings of the same action, for ours and those it is compared with. Poses are local; root motion is
/// scored by itself.
Table evaluate(const Networks& networks, const std::vector<Sequence>& test, const Evaluation& options);

std::string table_text(const Table& table);
nlohmann::ordered_json table_json(const Table& table);

/// The score that training chooses weights by: mean NDMS over ten seconds of four futures of each of a few windows an
/// action.
double validation_ndms(const Networks& networks, const std::vector<Sequence>& sequences);
/// Mean joint error, metres, of a baseline over the first second.
double validation_error(const Networks& networks, bool ltd, const std::vector<Sequence>& sequences);

}  // namespace inhabit::anticipate
