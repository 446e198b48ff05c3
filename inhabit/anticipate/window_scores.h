#pragma once
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "inhabit/anticipate/evaluate.h"
#include "inhabit/metrics/ndms.h"

namespace inhabit::anticipate {

/// Mean of what was added, without NaN.
struct Mean {
  double sum = 0;     ///< of the values
  int64_t count = 0;  ///< how many they are

  /// One more value; NaN is none.
  void add(double value) {
    if (std::isnan(value)) return;
    sum += value;
    ++count;
  }
  /// The mean; NaN without values.
  double value() const { return count > 0 ? sum / static_cast<double>(count) : Scores::kNone; }
};

/// The words of every recording of an action for a database (N, kappa, J, 3).
torch::Tensor action_database(const std::vector<Sequence>& sequences, const std::string& action, int64_t kappa,
                              WordKind kind);
/// The words of every recording of an action as they are, at the model's rate; none where it has none.
torch::Tensor action_words(const std::vector<Sequence>& sequences, const std::string& action, int64_t kappa,
                           WordKind kind);

/// Similarity of the words of futures (S, T, F) that end in each future frame: (S, T).
WordScores future_scores(const torch::Tensor& past, const torch::Tensor& futures, const WordIndex& database,
                         int64_t kappa, WordKind kind);

/// Mean joint speed (m/s) of local poses (..., T, 22, 3).
double joint_speed(const torch::Tensor& poses, double rate);

/// Millimetres: mean step of the joints of local poses from the last frame of past (t, F) to the first one of futures
/// (S, T, F).
double seam_step(const torch::Tensor& past, const torch::Tensor& futures);

/// How often each intention label follows each other one from frame to frame of recordings: (C, C) double, rows sum to
/// 1.
torch::Tensor label_transitions(const std::vector<Sequence>& recordings, const IntentionClusters& clusters);
/// The label of the last frame of past (t, F).
int64_t last_label(const torch::Tensor& past, const IntentionClusters& clusters);
/// The fraction of `frames` frames behind one of `label` that each label has by the transitions: (C) double.
torch::Tensor expected_fractions(const torch::Tensor& transitions, int64_t label, int64_t frames);
/// The fraction of the frames of futures (S, T, F) behind past (t, F) that each label has: (C) double.
torch::Tensor label_fractions(const torch::Tensor& past, const torch::Tensor& futures,
                              const IntentionClusters& clusters);

/// What futures are measured against.
struct Measure {
  const WordIndex& database;            ///< words of the test recordings of the action
  const std::vector<double>& horizons;  ///< seconds
  const Config& config;                 ///< of the model, for rates and lengths
  WordKind kind;                        ///< how poses of words are seen
  double real_speed;                    ///< m/s, mean joint speed of the action's test recordings
};
/// One method's futures (S, T, F) of one window, measured at the horizons; npss is left open.
Scores measure(const torch::Tensor& past, const torch::Tensor& futures, const torch::Tensor& truth, const Measure& by);

/// What one window adds to the NPSS of all of an action, their seconds 2 to 4 as one batch: npss_terms (S, 2) of
/// futures (S, T, F) with what came true (T', F); NaN where the window is not known for so long.
torch::Tensor spectrum_terms(const torch::Tensor& futures, const torch::Tensor& truth, double rate);
/// NPSS of windows (W, S, 2), mean over the samples; NaN where none is known.
double npss_of(const torch::Tensor& terms);

/// Every curve of scores.
inline constexpr std::array kCurveMembers = {&Scores::ndms,       &Scores::coded, &Scores::ratio,     &Scores::error,
                                             &Scores::best_error, &Scores::apd,   &Scores::root_error};
/// Calls visit(member) for each.
template <class Visit>
void visit_curves(const Visit& visit) {
  for (const auto curve : kCurveMembers) visit(curve);
}

/// Means of one method's scores, without NaN.
Scores mean_scores(const std::vector<const Scores*>& all);
/// Ratios to the row called "real motion", in all rows.
void add_ratios(std::vector<Scores>& rows, const std::vector<double>& horizons);

}  // namespace inhabit::anticipate
