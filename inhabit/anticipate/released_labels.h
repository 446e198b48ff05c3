#pragma once
#include <vector>

#include "inhabit/anticipate/intention.h"
#include "inhabit/anticipate/released_networks.h"

namespace inhabit::anticipate {

// Intention labels as the authors' training code has them: k-means of the codes that an autoencoder gives three poses
// of the legs, 12.5 a second. Poses are (T, 63), as intention_poses gives them, 25 a second.

inline constexpr int64_t kLabelHidden = 128,  ///< width of the autoencoder
    kLabelCode = 16;                          ///< width of its code

/// What the autoencoder sees of the frames about each frame: (T, 3, 14, 3), the upper body zero. Beyond the ends the
/// first and last frame stand.
torch::Tensor label_views(const torch::Tensor& poses);

/// Trains the autoencoder on `sequences` (T_i, 63) and clusters its codes; the same seed gives the same labels.
IntentionClusters cluster_released(const std::vector<torch::Tensor>& sequences, int64_t labels, uint64_t seed);

/// Label of every frame (T) int64.
torch::Tensor released_labels(const torch::Tensor& poses, const IntentionClusters& clusters);

}  // namespace inhabit::anticipate
