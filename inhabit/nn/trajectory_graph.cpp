#include "inhabit/nn/trajectory_graph.h"

#include <cmath>

#include "inhabit/math/dct.h"

namespace inhabit::nn {

using torch::Tensor;

constexpr double kDropout = 0.5;  // the original's

GraphConvolutionImpl::GraphConvolutionImpl(int64_t nodes, int64_t inputs, int64_t outputs) {
  const double bound = 1.0 / std::sqrt(static_cast<double>(outputs));
  const auto uniform = [&](at::IntArrayRef shape) { return torch::empty(shape).uniform_(-bound, bound); };
  graph = register_parameter("graph", uniform({nodes, nodes}));
  weight = register_parameter("weight", uniform({inputs, outputs}));
  bias = register_parameter("bias", uniform({outputs}));
}

Tensor GraphConvolutionImpl::forward(const Tensor& x) { return torch::matmul(graph, torch::matmul(x, weight)) + bias; }

TrajectoryGraphImpl::TrajectoryGraphImpl(int64_t nodes, int64_t past_frames, int64_t future_frames, int64_t hidden,
                                         int64_t blocks)
    : past(past_frames), future(future_frames) {
  const int64_t frames = past + future;
  in = register_module("in", GraphConvolution(nodes, frames, hidden));
  for (int64_t i = 0; i <= 2 * blocks; ++i)
    norms.push_back(register_module("norm" + std::to_string(i), BatchNorm(nodes * hidden)));
  for (int64_t i = 0; i < 2 * blocks; ++i)
    hidden_layers.push_back(register_module("hidden" + std::to_string(i), GraphConvolution(nodes, hidden, hidden)));
  out = register_module("out", GraphConvolution(nodes, hidden, frames));
  to_dct_ = padded_dct_matrix(past, future, frames);  // (P+T, P)
  from_dct_ = idct_matrix(frames, frames);            // (P+T, P+T)
}

Tensor TrajectoryGraphImpl::activated(const Tensor& x, size_t layer) {
  const Tensor y = norms[layer]->forward(x.flatten(1)).view(x.sizes()).tanh();
  return torch::dropout(y, kDropout, is_training());
}

Tensor TrajectoryGraphImpl::forward(const Tensor& past_frames) {
  const Tensor dct = torch::matmul(past_frames.transpose(1, 2), to_dct_.t().to(past_frames.device()));  // (B, K, P+T)
  Tensor x = activated(in->forward(dct), 0);
  for (size_t i = 0; i < hidden_layers.size(); i += 2)
    x = x + activated(hidden_layers[i + 1]->forward(activated(hidden_layers[i]->forward(x), i + 1)), i + 2);
  const Tensor course = torch::matmul(out->forward(x) + dct, from_dct_.t().to(past_frames.device()));
  return course.slice(2, past).transpose(1, 2);
}

}  // namespace inhabit::nn
