#pragma once
#include "inhabit/nn/residual_graph.h"

namespace inhabit::nn {

/// Trajectory dependencies (LTD, Mao et al. 2019): every coordinate's course over past and future, the last frame
/// repeated, as DCT coefficients; a residual graph network over the coordinates corrects them.
struct TrajectoryGraphImpl : ResidualGraphImpl {
  /// @param nodes K coordinates; @param blocks of two graph convolutions each.
  TrajectoryGraphImpl(int64_t nodes, int64_t past_frames, int64_t future_frames, int64_t hidden, int64_t blocks);
  /// (B, P, K) -> (B, T, K)
  torch::Tensor forward(const torch::Tensor& past_frames);

  int64_t past;    ///< P frames
  int64_t future;  ///< T frames

 private:
  torch::Tensor to_dct_, from_dct_;
};
TORCH_MODULE(TrajectoryGraph);

}  // namespace inhabit::nn
