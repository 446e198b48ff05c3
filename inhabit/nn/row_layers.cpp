#include "inhabit/nn/row_layers.h"

#include "inhabit/nn/gru_kernel.h"

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

void last_gru_state(const RowLayer& encode, const RowGru& gru, const float* x, int64_t count, float* state) {
  std::vector<float> encoded(static_cast<size_t>(encode.stride())), input(static_cast<size_t>(gru.from_input.stride())),
      recurrent(static_cast<size_t>(gru.from_state.stride()));
  std::fill_n(state, gru.hidden, 0.0F);
  for (int64_t t = 0; t < count; ++t) {
    apply(encode, x + t * encode.w.in, encode.w.in, 1, encoded.data());
    gru.input_gates(encoded.data(), input.data());
    gru.state_gates(state, recurrent.data());
    gru_update(gru.hidden, input.data(), recurrent.data(), state, state);
  }
}

}  // namespace inhabit::nn
