#pragma once
#include <vector>

#include "inhabit/inbetween/motion_autoencoder.h"
#include "inhabit/metrics/score_clips.h"

namespace inhabit::inbetween {

// Scores over the motion features that `inhabit eval inbetween` takes its Frechet distance of: windows of
// kFeatureFrames frames at 30 a second, one after the other from the start of each motion.

/// Features (N, 64) of the windows of all clips, over the floor y = 0 (over_floor). Throws Error where none is as long
/// as a window.
torch::Tensor features_of(const std::vector<ScoredClip>& clips, const MotionAutoencoder& network);

/// A Frechet distance and what it is taken over.
struct FidScore {
  double fid = 0;                 ///< squared distance, of features that have deviation 1 in training
  int64_t windows = 0;            ///< N, of the motion
  int64_t reference_windows = 0;  ///< M, of the reference
  int64_t dimensions = 0;         ///< principal directions of the reference (metrics/frechet.h)
};

/// Squared Frechet distance of features (N, 64) from those of real motion (M, 64), N and M > 1. Throws Error.
FidScore score_fid(const torch::Tensor& features, const torch::Tensor& reference);

/// Mean Euclidean distance between features (N, 64) over all pairs of windows, N > 1: as far as 64 features of
/// deviation 1 are apart real motion has about sqrt(2 * 64). Throws Error.
double score_diversity(const torch::Tensor& features);

}  // namespace inhabit::inbetween
