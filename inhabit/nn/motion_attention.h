#pragma once
#include "inhabit/nn/residual_graph.h"

namespace inhabit::nn {

/// Motion attention (HisRep, "History Repeats Itself", Mao et al. 2020): what followed earlier subsequences that were
/// like the last M frames, as DCT coefficients of M + T frames, weighted by how much alike they are; a residual graph
/// network over the coordinates corrects the last M frames, the last one repeated, with that beside them.
struct MotionAttentionImpl : ResidualGraphImpl {
  /// @param nodes K coordinates; @param query_frames M, at least 2; @param blocks of two graph convolutions each.
  MotionAttentionImpl(int64_t nodes, int64_t query_frames, int64_t future_frames, int64_t hidden, int64_t blocks);
  /// (B, P, K) -> (B, T, K), P at least M + T
  torch::Tensor forward(const torch::Tensor& past);

  /// `frames` that follow, T at a time, each time after all that is known by then: (B, P, K) -> (B, frames, K)
  torch::Tensor continued(const torch::Tensor& past, int64_t frames);

  /// How much each earlier subsequence counts, (B, P - M - T + 1), which sum to 1.
  torch::Tensor attention(const torch::Tensor& past);

  int64_t query;                        ///< M frames
  int64_t future;                       ///< T frames
  torch::nn::Sequential query_network;  ///< (B, K, M) -> (B, hidden, 1)
  torch::nn::Sequential key_network;    ///< the same of every subsequence of M frames

 private:
  torch::Tensor pad_, to_dct_;
};
TORCH_MODULE(MotionAttention);

}  // namespace inhabit::nn
