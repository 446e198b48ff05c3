#pragma once
#include <torch/types.h>

namespace inhabit {

/// Path error (B, T): distance between predicted and true root. Metres in, metres out (the papers print millimetres).
/// @param predicted, truth (B, T, J, 3) world joints; @param root index of the root joint.
torch::Tensor path_error(const torch::Tensor& predicted, const torch::Tensor& truth, int64_t root);

/// Pose error (B, T): mean over the other joints of the distance after both roots are moved to the origin.
torch::Tensor pose_error(const torch::Tensor& predicted, const torch::Tensor& truth, int64_t root);

/// Errors of several futures of one observation, and those of the best of them.
struct FuturesError {
  torch::Tensor each;  ///< (S, T) metres; of futures_error the mean over the joints but the root
  torch::Tensor best;  ///< (T) of the future whose mean over time is the least
};

/// @param each (S, T) errors of futures, metres
FuturesError with_best(const torch::Tensor& each);

/// @param futures (S, T, 22, 3), truth (T, 22, 3) local poses (motion/local_pose.h), whose root is the origin.
FuturesError futures_error(const torch::Tensor& futures, const torch::Tensor& truth);

/// Which of several futures in the world is nearest to what happened: (B) int64, the one whose joints are off least in
/// the mean over frames and joints, the path of the root included.
/// @param futures (B, K, T, J, 3), truth (B, T, J, 3) world joints
torch::Tensor nearest_future(const torch::Tensor& futures, const torch::Tensor& truth);

}  // namespace inhabit
