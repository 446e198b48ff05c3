#pragma once
#include <torch/torch.h>

#include <tuple>

namespace inhabit::nn {

/// What a GRU has made of sequences when it has seen all of them: the last hidden state (B, H) of its last layer, from
/// zero. @param x (B, T, F), whether the GRU's own batches come first or not
inline torch::Tensor last_state(torch::nn::GRU& gru, const torch::Tensor& x) {
  return std::get<1>(gru->forward(gru->options.batch_first() ? x : x.transpose(0, 1)))[-1];
}

}  // namespace inhabit::nn
