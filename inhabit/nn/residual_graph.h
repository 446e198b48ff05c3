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

/// The graph network of Mao et al. 2019 and 2020 over K coordinates: a graph convolution in, residual blocks of two,
/// one out; batch norm, tanh and dropout behind all but the last.
struct ResidualGraphImpl : torch::nn::Module {
  /// @param inputs, outputs features of a coordinate @param dropout in training
  ResidualGraphImpl(int64_t nodes, int64_t inputs, int64_t hidden, int64_t outputs, int64_t blocks, double dropout);
  /// (B, K, inputs) -> (B, K, outputs)
  torch::Tensor convolved(const torch::Tensor& x);

  GraphConvolution in{nullptr};                 ///< inputs to hidden
  GraphConvolution out{nullptr};                ///< hidden to outputs
  std::vector<GraphConvolution> hidden_layers;  ///< two a block
  std::vector<BatchNorm> norms;                 ///< behind `in` and every hidden layer

 private:
  torch::Tensor activated(const torch::Tensor& x, size_t layer);
  double dropout_;
};

}  // namespace inhabit::nn
