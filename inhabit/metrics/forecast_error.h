#pragma once
#include <torch/types.h>

namespace inhabit {

/// Path error (B, T): distance between predicted and true root. Metres in, metres out (the papers print millimetres).
/// @param predicted, truth (B, T, J, 3) world joints; @param root index of the root joint.
torch::Tensor path_error(const torch::Tensor& predicted, const torch::Tensor& truth, int64_t root);

/// Pose error (B, T): mean over the other joints of the distance after both roots are moved to the origin.
torch::Tensor pose_error(const torch::Tensor& predicted, const torch::Tensor& truth, int64_t root);

}  // namespace inhabit
