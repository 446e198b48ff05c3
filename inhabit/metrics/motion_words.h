#pragma once
#include <torch/types.h>

#include <vector>

namespace inhabit {

/// Wrists, elbows, shoulders, hips, knees and ankles of the standard skeleton: what motion words are made of
/// (intention-driven anticipation, 4.2).
const std::vector<int64_t>& word_joints();

/// Overlapping motion words (T-kappa+1, kappa, J, 3) of positions (T, J, 3); none where T < kappa.
torch::Tensor motion_words(const torch::Tensor& positions, int64_t kappa);

/// Words (N, kappa, J, 3) each moved on the ground and rotated about the vertical as a whole, so that in its first
/// frame the middle between the hips is above the origin and the line between them along x, the left one at +x.
/// @param left_hip, right_hip rows of the words' joints.
torch::Tensor placed_words(const torch::Tensor& words, int64_t left_hip, int64_t right_hip);

/// What Eq. 9 scores: the words of the joints named by word_joints(), placed, of a motion (T, 22, 3) on the standard
/// joints: (T-kappa+1, kappa, 12, 3).
torch::Tensor pose_words(const torch::Tensor& joints, int64_t kappa);

/// Exact nearest neighbours among motion words by Euclidean distance over the flattened positions. A distance never
/// exceeds that of the projections on the leading principal axes joined with the lengths of what is left, and of those
/// a matrix product finds nearly all words that cannot be nearest; the others are measured in full.
class WordIndex {
 public:
  /// @param words (N, ...) finite positions, N > 0. They are kept as (N, D).
  explicit WordIndex(const torch::Tensor& words);

  /// Row (Q) int64 of the nearest word for each of (Q, ...); the first of equals.
  torch::Tensor nearest(const torch::Tensor& queries) const;
  const torch::Tensor& words() const { return words_; }  ///< (N, D)

 private:
  torch::Tensor projected(const torch::Tensor& words) const;  ///< (N, K+1)
  torch::Tensor words_, mean_, axes_;                         ///< (N, D), (D), (D, K)
  torch::Tensor low_, low_squared_;                           ///< (K+1, N), (N)
};

}  // namespace inhabit
