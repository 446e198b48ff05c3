#pragma once
#include <torch/types.h>

#include "inhabit/nn/point_ops.h"

namespace inhabit::nn {

/// conv3d with a 3x3x3 kernel and padding 1 that skips voxels of `x` whose channels are all zero: the same result and
/// gradients (CPU; other devices take the dense operator) for a fraction of the work. The gradient of a skipped voxel
/// is 0: use it where such voxels do not depend on parameters, or through grid_conv3d_over().
/// @param x (B, C, G, G, G); @param weight (O, C, 3, 3, 3); @param bias (O).
torch::Tensor grid_conv3d(const torch::Tensor& x, const torch::Tensor& weight, const torch::Tensor& bias);

/// The same of the grid that scatter(average, x) fills, which is never stored. Gradients reach every point.
/// @param average voxel_average(); @param x (B, C, N).
torch::Tensor grid_conv3d_of_points(const SparseMap& average, const torch::Tensor& x, const torch::Tensor& weight,
                                    const torch::Tensor& bias);

/// conv3d for a grid that is `background` (C) nearly everywhere: the convolution of a constant grid has 27 different
/// outputs (inside, at faces, edges and corners, because of the zero padding), and only what differs from it is
/// convolved. Exact whatever the background; gradients are exact where `background` carries the gradient of the voxels
/// that equal it.
torch::Tensor grid_conv3d_over(const torch::Tensor& background, const torch::Tensor& x, const torch::Tensor& weight,
                               const torch::Tensor& bias);

}  // namespace inhabit::nn
