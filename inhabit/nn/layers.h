#pragma once
#include <torch/torch.h>

#include <vector>

#include "inhabit/nn/batch_norm.h"
#include "inhabit/nn/point_ops.h"

namespace inhabit::nn {

/// Slope of the leaky ReLU behind a voxel convolution, and what its batch norm adds to the variance.
inline constexpr double kVoxelLeak = 0.1,  ///< slope under 0
    kVoxelNormEps = 1e-4;                  ///< added to the variance

/// Features (B, C, N) at points (B, N, 3): what the point layers take and give.
struct PointFeatures {
  torch::Tensor features;  ///< (B, C, N)
  torch::Tensor points;    ///< (B, N, 3) metres
};

/// Pointwise linear layers, each with batch norm and ReLU. `dimensions` 1 takes (B, C, N), 2 takes (B, C, M, U).
struct SharedMlpImpl : torch::nn::Module {
  /// @param widths of the layers, one after the other
  SharedMlpImpl(int64_t in_channels, const std::vector<int>& widths, int dimensions);
  /// C becomes the last of the widths.
  torch::Tensor forward(const torch::Tensor& x) { return layers->forward(x); }

  torch::nn::Sequential layers;  ///< convolution of size 1, batch norm, ReLU, and so on
};
TORCH_MODULE(SharedMlp);

/// Squeeze and excitation over a voxel grid (B, C, X, Y, Z): channels are scaled by a gate computed from their means.
struct VoxelGateImpl : torch::nn::Module {
  /// @param channels C
  explicit VoxelGateImpl(int64_t channels);
  /// The same shape.
  torch::Tensor forward(const torch::Tensor& x);

  torch::nn::Sequential fc;  ///< C to C / 8 to C, ReLU between, a sigmoid behind
};
TORCH_MODULE(VoxelGate);

/// Point-voxel convolution: points averaged into a grid, two 3x3x3 convolutions and a gate there, interpolated back at
/// the points and added to a pointwise layer. Far from every occupied voxel the convolutions see constants, and on the
/// CPU that part of the grid is had in closed form; `dense` makes it plain.
struct PointVoxelConvImpl : torch::nn::Module {
  /// @param grid_size voxels along each side
  PointVoxelConvImpl(int64_t in_channels, int64_t out_channels, int64_t grid_size);
  /// At the same points.
  PointFeatures forward(const PointFeatures& input);

  int64_t grid;                                         ///< voxels along each side
  bool dense = false;                                   ///< all of the grid is convolved
  torch::nn::Sequential voxel_layers;                   ///< convolutions, norms, leaky ReLUs, gate
  SharedMlp point_features{nullptr};                    ///< the pointwise layer
  torch::nn::Conv3d convolutions[2]{nullptr, nullptr};  ///< inside voxel_layers
  BatchNorm norms[2]{nullptr, nullptr};                 ///< inside voxel_layers
  VoxelGate gate{nullptr};                              ///< inside voxel_layers

 private:
  torch::Tensor convolve(const SparseMap& average, const torch::Tensor& features);
};
TORCH_MODULE(PointVoxelConv);

/// Fewer points: centres by furthest point sampling, each with the largest response of a shared MLP over the points
/// around it (position relative to the centre, then features).
struct SetAbstractionImpl : torch::nn::Module {
  /// @param ball_radius metres around a centre @param neighbour_count points that it sees at most @param widths of the
  /// MLP
  SetAbstractionImpl(int64_t in_channels, int64_t centre_count, double ball_radius, int64_t neighbour_count,
                     const std::vector<int>& widths);
  /// At the centres.
  PointFeatures forward(const PointFeatures& input);

  int64_t centres;         ///< points that are left
  int64_t neighbours;      ///< points that a centre sees at most
  double radius;           ///< metres
  SharedMlp mlp{nullptr};  ///< on each neighbour, before the largest response is taken
};
TORCH_MODULE(SetAbstraction);

/// More points: features interpolated from the centres, joined to the finer points' own, through a shared MLP.
struct FeaturePropagationImpl : torch::nn::Module {
  /// @param in_channels of coarse and fine features together @param widths of the MLP
  FeaturePropagationImpl(int64_t in_channels, const std::vector<int>& widths);
  /// @param coarse what the centres carry; @param fine the points to carry it to and their own features.
  PointFeatures forward(const PointFeatures& coarse, const PointFeatures& fine);

  SharedMlp mlp{nullptr};  ///< on what was joined
};
TORCH_MODULE(FeaturePropagation);

}  // namespace inhabit::nn
