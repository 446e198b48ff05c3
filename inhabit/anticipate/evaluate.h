#pragma once
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "inhabit/anticipate/futures.h"
#include "inhabit/anticipate/model_file.h"
#include "inhabit/anticipate/sample.h"
#include "inhabit/data/measured_parts.h"
#include "inhabit/metrics/motion_words.h"
#include "inhabit/metrics/score_table.h"
#include "inhabit/progress.h"

namespace inhabit::anticipate {

/// One method on one action, or over all of them. Curves have a value a horizon; NaN where the recordings end earlier,
/// and where a row has none.
struct Scores {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();  ///< there is no value

  std::string method;              ///< its name in the table
  std::vector<double> ndms;        ///< Eq. 9 over the words that end in the 0.4 s up to the horizon
  std::vector<double> coded;       ///< the same in the form of the authors' code (NdmsForm::coded)
  std::vector<double> ratio;       ///< ndms over that of real motion
  std::vector<double> error;       ///< mm, mean joint error at the horizon, all futures
  std::vector<double> best_error;  ///< mm, of the future nearest to what came true over its known part
  std::vector<double> apd;         ///< metres; deterministic methods have 0
  std::vector<double> root_error;  ///< mm, of the root's place on the ground
  double npss = kNone;             ///< over 2 to 4 s of all windows that know them, as one batch
  double sequence_apd = kNone;     ///< Table 5: metres, of whole futures of 4 s
  double speed_ratio = kNone;      ///< mean joint speed of 4 s to the end over that of the real motion
  double late_ratio = kNone;       ///< mean of `ratio` from 1.6 s on
  double seam = kNone;             ///< mm, mean step of the joints of local poses from the last observed frame on
  double intentions = kNone;       ///< by how much intentions are not as often as the transitions of other
                                   ///< recordings of the action have them from the windows' last labels on: half of
                                   ///< the summed differences, 0 to 1
};

/// Scores of all methods.
struct Table {
  bool whole = true;             ///< false: other parts are still to come, and there is nothing in it
  std::vector<double> horizons;  ///< seconds
  int64_t samples = 0;           ///< futures of each observation
  /// One action, or their mean.
  struct Action {
    std::string name;            ///< as the recordings are labelled
    int64_t windows = 0;         ///< observations
    int64_t words = 0;           ///< in the database
    int64_t training_words = 0;  ///< of real motion; 0: the action has no other recording
    std::vector<Scores> rows;    ///< a method each; the last, where there is one, "real motion"
  };
  std::vector<Action> actions;        ///< then their mean, named "mean"
  std::vector<Action> apart;          ///< actions without any other recording, of which the mean knows nothing
  std::vector<std::string> left_out;  ///< actions without a test window
};

/// How methods are compared.
struct Evaluation {
  int64_t samples = 50;              ///< futures of each observation
  int64_t windows = 8;               ///< of each action
  double seconds = 30;               ///< longest horizon
  uint64_t seed = 1;                 ///< of the futures
  WordKind words = WordKind::poses;  ///< of which joints, and how placed
  Progress progress = {};            ///< told how many observations' rows are done
  MeasuredParts parts = {};          ///< of the observations
};

/// What is scored together: networks, the recordings that they are tested on, and all others, which rows that remember
/// and that of real motion are made of.
struct Fold {
  Networks networks;                    ///< none of them need be there
  std::vector<Sequence> test;           ///< recordings that windows and database are of
  std::vector<Sequence> training = {};  ///< empty: no such rows, and no action stands apart
};

/// The paper's protocol (4, 4.2, 5): futures of every test window scored against the motion words of the test
/// recordings of the same action, for ours and those it is compared with. Poses are local; root motion is scored by
/// itself. "real motion", the ceiling, is what the words of the other recordings of the action score. Windows of
/// several folds (recordings left out by turns) count as those of one, each against its own fold's database.
Table evaluate(const std::vector<Fold>& folds, const Evaluation& options);

/// The table as text: by action and method, NDMS over the horizons and single numbers; then each other score over the
/// horizons as the mean over actions.
std::string table_text(const Table& table);
/// The table as JSON, with every score of every action over the horizons; null where there is no value.
nlohmann::ordered_json table_json(const Table& table);

/// The score that training chooses weights by: mean NDMS over ten seconds of four futures of each of a few windows an
/// action.
double validation_ndms(const Networks& networks, const std::vector<Sequence>& sequences);
/// Mean pose error (metrics/forecast_error.h), metres, of a baseline over the first second.
double validation_error(const Networks& networks, BaselineFuture baseline, const std::vector<Sequence>& sequences);

}  // namespace inhabit::anticipate
