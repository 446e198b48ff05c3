#pragma once
#include <torch/torch.h>

#include <vector>

#include "inhabit/nn/batch_norm.h"

namespace inhabit::nn {

/// Graph convolution with a learned graph: (B, K, in) -> (B, K, out), y = A x W + b.
struct GraphConvolutionImpl : torch::nn::Module {
  /// @param nodes K @param inputs, outputs features of a node
  GraphConvolutionImpl(int64_t nodes, int64_t inputs, int64_t outputs);
  /// y of x.
  torch::Tensor forward(const torch::Tensor& x);

  torch::Tensor graph;   ///< A (K, K)
  torch::Tensor weight;  ///< W (in, out)
  torch::Tensor bias;    ///< b (out)
};
TORCH_MODULE(GraphConvolution);

/// Trajectory dependencies (LTD, Mao et al. 2019): every coordinate's course over past and future, the last frame
/// repeated, as DCT coefficients; a residual graph network over the coordinates corrects them.
struct TrajectoryGraphImpl : torch::nn::Module {
  /// @param nodes K coordinates; @param blocks of two graph convolutions each.
  TrajectoryGraphImpl(int64_t nodes, int64_t past_frames, int64_t future_frames, int64_t hidden, int64_t blocks);
  /// (B, P, K) -> (B, T, K)
  torch::Tensor forward(const torch::Tensor& past_frames);

  int64_t past;                                 ///< P frames
  int64_t future;                               ///< T frames
  GraphConvolution in{nullptr};                 ///< P+T coefficients to hidden
  GraphConvolution out{nullptr};                ///< hidden to P+T coefficients
  std::vector<GraphConvolution> hidden_layers;  ///< two a block
  std::vector<BatchNorm> norms;                 ///< behind `in` and every hidden layer

 private:
  torch::Tensor activated(const torch::Tensor& x, size_t layer);
  torch::Tensor to_dct_, from_dct_;
};
TORCH_MODULE(TrajectoryGraph);

}  // namespace inhabit::nn
