#include "inhabit/nn/residual_graph.h"

#include <cmath>

namespace inhabit::nn {

using torch::Tensor;

GraphConvolutionImpl::GraphConvolutionImpl(int64_t nodes, int64_t inputs, int64_t outputs) {
  const double bound = 1.0 / std::sqrt(static_cast<double>(outputs));
  const auto uniform = [&](at::IntArrayRef shape) { return torch::empty(shape).uniform_(-bound, bound); };
  graph = register_parameter("graph", uniform({nodes, nodes}));
  weight = register_parameter("weight", uniform({inputs, outputs}));
  bias = register_parameter("bias", uniform({outputs}));
}

Tensor GraphConvolutionImpl::forward(const Tensor& x) { return torch::matmul(graph, torch::matmul(x, weight)) + bias; }

ResidualGraphImpl::ResidualGraphImpl(int64_t nodes, int64_t inputs, int64_t hidden, int64_t outputs, int64_t blocks,
                                     double dropout)
    : dropout_(dropout) {
  in = register_module("in", GraphConvolution(nodes, inputs, hidden));
  for (int64_t i = 0; i <= 2 * blocks; ++i)
    norms.push_back(register_module("norm" + std::to_string(i), BatchNorm(nodes * hidden)));
  for (int64_t i = 0; i < 2 * blocks; ++i)
    hidden_layers.push_back(register_module("hidden" + std::to_string(i), GraphConvolution(nodes, hidden, hidden)));
  out = register_module("out", GraphConvolution(nodes, hidden, outputs));
}

Tensor ResidualGraphImpl::activated(const Tensor& x, size_t layer) {
  const Tensor y = norms[layer]->forward(x.flatten(1)).view(x.sizes()).tanh();
  return torch::dropout(y, dropout_, is_training());
}

Tensor ResidualGraphImpl::convolved(const Tensor& x) {
  Tensor y = activated(in->forward(x), 0);
  for (size_t i = 0; i < hidden_layers.size(); i += 2)
    y = y + activated(hidden_layers[i + 1]->forward(activated(hidden_layers[i]->forward(y), i + 1)), i + 2);
  return out->forward(y);
}

}  // namespace inhabit::nn
