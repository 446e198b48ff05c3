#pragma once
#include <torch/torch.h>

#include <cstdint>
#include <vector>

#include "inhabit/nn/layers.h"
#include "inhabit/nn/point_kernel.h"
#include "inhabit/nn/row_layers.h"

namespace inhabit::nn {

// Inference of the point-voxel layers over rows: features of one cloud lie as (N, stride) floats, stride a multiple of
// 64, columns beyond the channels 0.

/// Features of a cloud. Rows not listed in `full` hold only their first `shallow` channels, the rest being zero.
struct Rows {
  std::vector<float> data;
  int64_t count = 0, channels = 0, stride = 0;
  int64_t shallow = 0;
  std::vector<int32_t> full, bare;  ///< both empty where every row is full

  void resize(int64_t rows, int64_t channel_count);
  bool listed() const { return !full.empty() || !bare.empty(); }
  float* row(int64_t i) { return data.data() + i * stride; }
  const float* row(int64_t i) const { return data.data() + i * stride; }
};

/// Pairs (input row, output row) of a 3x3x3 convolution by chunk of outputs and tap.
struct TapPairs {
  std::vector<int32_t> from, to;
  std::vector<int32_t> begin;  ///< chunks * 27 + 1
  int64_t chunk = 0;           ///< outputs per chunk
};

/// Which voxels of a grid a cloud occupies and which a convolution can reach from there. Depends on positions only, so
/// layers of the same points and grid share one.
struct GridPlan {
  /// @param points (1, N, 3); @param full as in Rows: points that make their voxel full (empty: all are).
  GridPlan(const torch::Tensor& points, int64_t grid_size, const std::vector<int32_t>& full);

  int64_t grid = 0, points = 0;
  int64_t occupied = 0, once = 0, twice = 0;       ///< voxels: occupied, reached by one convolution, by two
  std::vector<int32_t> voxel_begin, voxel_points;  ///< points of each occupied voxel
  std::vector<char> voxel_full;                    ///< some point of the voxel is full
  TapPairs first_full, first_bare;                 ///< occupied -> once
  TapPairs second;                                 ///< once -> twice
  std::vector<int32_t> corners;                    ///< (N, 8) rows among `twice`
  std::vector<float> corner_weights;               ///< (N, 8)
  std::vector<int8_t> kind;                        ///< of each of `twice`: which of the 27 kinds of voxel it is
  std::vector<int64_t> unreached;                  ///< (27) voxels of each kind that are not among `twice`
};

/// PointVoxelConv, folded.
class FastPointVoxelConv {
 public:
  explicit FastPointVoxelConv(const PointVoxelConv& layer);
  int64_t grid() const { return grid_; }
  void operator()(const GridPlan& plan, const Rows& x, Rows& y);

 private:
  int64_t grid_, in_, out_;
  std::vector<PackedMatrix> first_, second_;  // one per tap
  std::vector<float> first_bias_, background_, constants_;
  RowLayer point_, squeeze_, excite_;
  std::vector<float> averages_, once_, twice_, sums_;
};

/// SetAbstraction, folded.
class FastSetAbstraction {
 public:
  explicit FastSetAbstraction(const SetAbstraction& layer);
  /// @return the centres (1, M, 3).
  torch::Tensor operator()(const torch::Tensor& points, const Rows& x, Rows& y);

 private:
  int64_t centres_, neighbours_;
  float squared_radius_;
  RowLayer offset_, feature_;  // the first layer, split; the bias is in feature_
  std::vector<RowLayer> later_;
  std::vector<float> per_point_;
};

/// FeaturePropagation, folded. @param coarse_channels of the features that are interpolated.
class FastFeaturePropagation {
 public:
  FastFeaturePropagation(const FeaturePropagation& layer, int64_t coarse_channels);
  /// @param first channel of `fine` from which its features count.
  void operator()(const torch::Tensor& coarse_points, const Rows& coarse, const torch::Tensor& fine_points,
                  const Rows& fine, int64_t first_channel, Rows& y);

 private:
  RowLayer carried_, own_;  // the first layer, split; the bias is in own_
  std::vector<RowLayer> later_;
  std::vector<float> per_centre_;
};

}  // namespace inhabit::nn
