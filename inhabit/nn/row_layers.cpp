#include "inhabit/nn/row_layers.h"

#include <cmath>

namespace inhabit::nn {

using torch::Tensor;

FoldedNorm folded_norm(const torch::nn::Module& batch_norm, double eps) {
  const auto parameters = batch_norm.named_parameters();
  const auto buffers = batch_norm.named_buffers();
  const auto exact = [](const Tensor& t) { return t.detach().to(torch::kCPU, torch::kFloat64); };
  const Tensor scale = exact(parameters["weight"]) / (exact(buffers["running_var"]) + eps).sqrt();
  return {scale, exact(parameters["bias"]) - exact(buffers["running_mean"]) * scale};
}

RowLayer row_layer(const Tensor& weight, const Tensor& bias, const FoldedNorm& norm) {
  const Tensor w = (weight.detach().to(torch::kCPU, torch::kFloat64).flatten(1) * norm.scale.unsqueeze(1))
                       .to(torch::kFloat32)
                       .contiguous();
  Tensor shift = norm.shift;
  if (bias.defined()) shift = shift + bias.detach().to(torch::kCPU, torch::kFloat64) * norm.scale;
  const Tensor b = shift.to(torch::kFloat32).contiguous();
  RowLayer layer;
  layer.w = pack_matrix(w.data_ptr<float>(), w.size(1), w.size(0), 1, w.size(1));
  layer.bias.assign(static_cast<size_t>(layer.stride()), 0.0F);
  std::copy_n(b.data_ptr<float>(), b.numel(), layer.bias.begin());
  return layer;
}

RowLayer row_layer(const Tensor& weight, const Tensor& bias) {
  const auto exact = torch::TensorOptions().dtype(torch::kFloat64);
  return row_layer(weight, bias, {torch::ones({weight.size(0)}, exact), torch::zeros({weight.size(0)}, exact)});
}

void apply(const RowLayer& layer, const float* x, int64_t x_stride, int64_t count, float* y) {
  for (int64_t i = 0; i < count; ++i) std::copy(layer.bias.begin(), layer.bias.end(), y + i * layer.stride());
  accumulate_rows(layer.w, layer.w.in, x, x_stride, nullptr, nullptr, count, y);
}

RowGru row_gru(const Tensor& weight_ih, const Tensor& weight_hh, const Tensor& bias_ih, const Tensor& bias_hh) {
  return {row_layer(weight_ih, bias_ih), row_layer(weight_hh, bias_hh), weight_hh.size(1)};
}

void gru_step(const RowGru& gru, const float* input_gates, const float* state_gates, const float* state, float* next) {
  const auto sigmoid = [](float x) { return 1.0F / (1.0F + std::exp(-x)); };
  const int64_t n = gru.hidden;
  for (int64_t i = 0; i < n; ++i) {
    const float reset = sigmoid(input_gates[i] + state_gates[i]);
    const float update = sigmoid(input_gates[n + i] + state_gates[n + i]);
    const float candidate = std::tanh(input_gates[2 * n + i] + reset * state_gates[2 * n + i]);
    next[i] = (1.0F - update) * candidate + update * state[i];
  }
}

void last_gru_state(const RowLayer& encode, const RowGru& gru, const float* x, int64_t count, float* state) {
  std::vector<float> encoded(static_cast<size_t>(encode.stride())), input(static_cast<size_t>(gru.from_input.stride())),
      recurrent(static_cast<size_t>(gru.from_state.stride()));
  std::fill_n(state, gru.hidden, 0.0F);
  for (int64_t t = 0; t < count; ++t) {
    apply(encode, x + t * encode.w.in, encode.w.in, 1, encoded.data());
    gru.input_gates(encoded.data(), input.data());
    gru.state_gates(state, recurrent.data());
    gru_step(gru, input.data(), recurrent.data(), state, state);
  }
}

}  // namespace inhabit::nn
