#pragma once
#include <torch/types.h>

#include <map>
#include <string>
#include <vector>

namespace inhabit {

/// Wrists, elbows, shoulders, hips, knees and ankles of the standard skeleton: what motion words are made of
/// (intention-driven anticipation, 4.2).
const std::vector<int64_t>& word_joints();

/// Overlapping motion words (N, kappa, J, 3) of positions (T, J, 3), one from every frame on, each of every `stride`-th
/// frame; those that begin in frames 0, stride, 2 stride ... first. None where T is too short.
torch::Tensor motion_words(const torch::Tensor& positions, int64_t kappa, int64_t stride = 1);

/// Words (N, kappa, J, 3) each moved on the ground and rotated about the vertical as a whole, so that in its first
/// frame the middle between the hips is above the origin and the line between them along x, the left one at +x.
/// @param left_hip, right_hip rows of the words' joints.
torch::Tensor placed_words(const torch::Tensor& words, int64_t left_hip, int64_t right_hip);

/// Some joints of a motion (T, 22, 3) on the standard joints that lost its place and heading frame by frame: the root
/// at the origin, the line between the hips seen from above along x, the left one at +x. (T, rows, 3).
torch::Tensor word_poses(const torch::Tensor& joints, const std::vector<int64_t>& rows = word_joints());

/// What Eq. 9 scores: words of word_poses(). (N, kappa, 12, 3), ordered as in motion_words.
torch::Tensor pose_words(const torch::Tensor& joints, int64_t kappa, int64_t stride = 1);

/// How motions become words.
enum class WordKind {
  poses,  ///< pose_words, as the authors evaluate
  dlow,   ///< the same of more joints: spine, neck and head too, as in the 17 that DLow has of Human3.6M (Table 3). Of
          ///< these the standard skeleton lacks the nose, and the root does not move
  package,  ///< as the score's released package has them: 16 joints of the motion in the world, each word moved as a
            ///< whole (placed_words)
};
/// What users call them: their own names.
const std::map<std::string, WordKind>& word_kinds_by_name();
/// Words of a motion (T, 22, 3), world or, for all but the package, without place and heading: (N, kappa, 12, 15 or 16,
/// 3).
torch::Tensor words_of(const torch::Tensor& joints, int64_t kappa, WordKind kind = WordKind::poses);

/// The words that a recording (T, 22, 3) at `stride` times the rate gives a database: those that begin in each frame
/// and those of the mirror image; the package takes every `stride`-th frame as it is.
torch::Tensor database_words(const torch::Tensor& joints, int64_t kappa, int64_t stride,
                             WordKind kind = WordKind::poses);

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
