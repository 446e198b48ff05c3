#pragma once
#include <torch/torch.h>

#include <vector>

namespace inhabit::nn {

/// Graph convolution with a learned graph: (B, K, in) -> (B, K, out), y = A x W + b.
struct GraphConvolutionImpl : torch::nn::Module {
  GraphConvolutionImpl(int64_t nodes, int64_t inputs, int64_t outputs);
  torch::Tensor forward(const torch::Tensor& x);

  torch::Tensor graph, weight, bias;
};
TORCH_MODULE(GraphConvolution);

/// Trajectory dependencies (LTD, Mao et al. 2019): every coordinate's course over past and future, the last frame
/// repeated, as DCT coefficients; a residual graph network over the coordinates corrects them.
struct TrajectoryGraphImpl : torch::nn::Module {
  /// @param nodes K coordinates; @param blocks of two graph convolutions each.
  TrajectoryGraphImpl(int64_t nodes, int64_t past_frames, int64_t future_frames, int64_t hidden, int64_t blocks);
  /// (B, P, K) -> (B, T, K)
  torch::Tensor forward(const torch::Tensor& past_frames);

  int64_t past, future;
  GraphConvolution in{nullptr}, out{nullptr};
  std::vector<GraphConvolution> hidden_layers;
  std::vector<torch::nn::BatchNorm1d> norms;  ///< behind `in` and every hidden layer

 private:
  torch::Tensor activated(const torch::Tensor& x, size_t layer);
  torch::Tensor to_dct_, from_dct_;
};
TORCH_MODULE(TrajectoryGraph);

}  // namespace inhabit::nn
