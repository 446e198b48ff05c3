#pragma once
#include <torch/torch.h>

#include <vector>

#include "inhabit/nn/point_ops.h"

namespace inhabit::nn {

/// Slope of the leaky ReLU behind a voxel convolution, and epsilons of the batch norms (the latter PyTorch's default).
inline constexpr double kVoxelLeak = 0.1, kVoxelNormEps = 1e-4, kPointNormEps = 1e-5;

/// Features (B, C, N) at points (B, N, 3): what the point layers take and give.
struct PointFeatures {
  torch::Tensor features, points;
};

/// Pointwise linear layers, each with batch norm and ReLU. `dimensions` 1 takes (B, C, N), 2 takes (B, C, M, U).
struct SharedMlpImpl : torch::nn::Module {
  SharedMlpImpl(int64_t in_channels, const std::vector<int>& widths, int dimensions);
  torch::Tensor forward(const torch::Tensor& x) { return layers->forward(x); }

  torch::nn::Sequential layers;
};
TORCH_MODULE(SharedMlp);

/// Squeeze and excitation over a voxel grid (B, C, X, Y, Z): channels are scaled by a gate computed from their means.
struct VoxelGateImpl : torch::nn::Module {
  explicit VoxelGateImpl(int64_t channels);
  torch::Tensor forward(const torch::Tensor& x);

  torch::nn::Sequential fc;
};
TORCH_MODULE(VoxelGate);

/// Point-voxel convolution: points averaged into a grid, two 3x3x3 convolutions and a gate there, interpolated back at
/// the points and added to a pointwise layer. Far from every occupied voxel the convolutions see constants, and on the
/// CPU that part of the grid is had in closed form; `dense` makes it plain.
struct PointVoxelConvImpl : torch::nn::Module {
  PointVoxelConvImpl(int64_t in_channels, int64_t out_channels, int64_t grid_size);
  PointFeatures forward(const PointFeatures& input);

  int64_t grid;
  bool dense = false;
  torch::nn::Sequential voxel_layers;
  SharedMlp point_features{nullptr};
  torch::nn::Conv3d convolutions[2]{nullptr, nullptr};  ///< inside voxel_layers
  torch::nn::BatchNorm3d norms[2]{nullptr, nullptr};
  VoxelGate gate{nullptr};

 private:
  torch::Tensor convolve(const SparseMap& average, const torch::Tensor& features);
};
TORCH_MODULE(PointVoxelConv);

/// Fewer points: centres by furthest point sampling, each with the largest response of a shared MLP over the points
/// around it (position relative to the centre, then features).
struct SetAbstractionImpl : torch::nn::Module {
  SetAbstractionImpl(int64_t in_channels, int64_t centre_count, double ball_radius, int64_t neighbour_count,
                     const std::vector<int>& widths);
  PointFeatures forward(const PointFeatures& input);

  int64_t centres, neighbours;
  double radius;
  SharedMlp mlp{nullptr};
};
TORCH_MODULE(SetAbstraction);

/// More points: features interpolated from the centres, joined to the finer points' own, through a shared MLP.
struct FeaturePropagationImpl : torch::nn::Module {
  FeaturePropagationImpl(int64_t in_channels, const std::vector<int>& widths);
  /// @param coarse what the centres carry; @param fine the points to carry it to and their own features.
  PointFeatures forward(const PointFeatures& coarse, const PointFeatures& fine);

  SharedMlp mlp{nullptr};
};
TORCH_MODULE(FeaturePropagation);

}  // namespace inhabit::nn
