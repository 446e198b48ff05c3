#pragma once
#include <torch/types.h>

namespace inhabit::nn {

// What the point-voxel layers need to know about where points lie. Points are (B, N, 3) float32, features (B, C, N).
// Nothing here has gradients with respect to positions. Each has a loop for CPU tensors and the same in torch operators
// for other devices.

/// A sparse linear map along the last axis: output i of M is the sum over k of weight[b, i, k] input[b, :, index[b, i,
/// k]].
struct SparseMap {
  torch::Tensor index;   ///< (B, M, K) int64
  torch::Tensor weight;  ///< (B, M, K); undefined where every weight is 1
  int64_t inputs = 0;    ///< length of the input's last axis
};

/// (B, C, inputs) -> (B, C, M). Differentiable in x.
torch::Tensor gather(const SparseMap& map, const torch::Tensor& x);

/// The adjoint: (B, C, M) -> (B, C, inputs). Differentiable in x.
torch::Tensor scatter(const SparseMap& map, const torch::Tensor& x);

/// Positions in voxel units: centred, divided by twice the largest distance from the centre, shifted by 0.5, times
/// `grid` and clamped to [0, grid - 1]. (B, N, 3).
torch::Tensor voxel_coordinates(const torch::Tensor& points, int64_t grid);

/// Adjoint of averaging: scatter() over it turns point features into the mean of each voxel's points, voxel
/// (x grid + y) grid + z, a point belonging to the nearest voxel of its coordinates. Empty voxels get 0.
SparseMap voxel_average(const torch::Tensor& coordinates, int64_t grid);

/// Trilinear interpolation of voxel features at the points: gather() over it.
SparseMap voxel_interpolation(const torch::Tensor& coordinates, int64_t grid);

/// Indices (B, count) int64 of points each furthest from those before it, starting with point 0.
torch::Tensor furthest_points(const torch::Tensor& points, int64_t count);

/// Indices (B, M, neighbours) int64 of the first points, in order, closer than `radius` to each of the centres
/// (B, M, 3); the first found fills the rest, point 0 where none is found.
torch::Tensor ball_neighbours(const torch::Tensor& points, const torch::Tensor& centres, double radius,
                              int64_t neighbours);

/// Interpolation at `points` from the three nearest centres by inverse squared distance (floored at 1e-10 m^2).
SparseMap nearest_interpolation(const torch::Tensor& points, const torch::Tensor& centres);

/// Rows `index` (B, M) of points (B, N, 3).
torch::Tensor select_points(const torch::Tensor& points, const torch::Tensor& index);

}  // namespace inhabit::nn
