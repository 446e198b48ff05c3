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

RowLayer row_layer_of_taps(const Tensor& weight, const Tensor& bias) {
  return row_layer(weight.flatten(0, 1).t(), bias);
}

void apply(const RowLayer& layer, const float* x, int64_t x_stride, int64_t count, float* y) {
  for (int64_t i = 0; i < count; ++i) std::copy(layer.bias.begin(), layer.bias.end(), y + i * layer.stride());
  accumulate_rows(layer.w, layer.w.in, x, x_stride, nullptr, nullptr, count, y);
}

RowGru row_gru(const torch::nn::Module& gru) {
  const auto parameters = gru.named_parameters();
  const std::string layer = parameters.contains("weight_ih_l0") ? "_l0" : "";
  const auto of = [&](const char* name) { return parameters[name + layer]; };
  return {row_layer(of("weight_ih"), of("bias_ih")), row_layer(of("weight_hh"), of("bias_hh")),
          of("weight_hh").size(1)};
}

namespace {

/// The state after `count` rows; row(t) is where the gates' input of time t lies.
template <class RowAt>
void run_gru(const RowGru& gru, int64_t count, const RowAt& row, float* state) {
  std::vector<float> input(static_cast<size_t>(gru.from_input.stride())),
      recurrent(static_cast<size_t>(gru.from_state.stride()));
  std::fill_n(state, gru.hidden, 0.0F);
  for (int64_t t = 0; t < count; ++t) {
    gru.input_gates(row(t), input.data());
    gru.state_gates(state, recurrent.data());
    gru_update(gru.hidden, input.data(), recurrent.data(), state, state);
  }
}

}  // namespace

void last_gru_state(const RowGru& gru, const float* x, int64_t count, float* state) {
  run_gru(
      gru, count, [&](int64_t t) { return x + t * gru.from_input.w.in; }, state);
}

void last_gru_state(const RowLayer& encode, const RowGru& gru, const float* x, int64_t count, float* state) {
  std::vector<float> encoded(static_cast<size_t>(encode.stride()));
  const auto row = [&](int64_t t) -> const float* {
    apply(encode, x + t * encode.w.in, encode.w.in, 1, encoded.data());
    return encoded.data();
  };
  run_gru(gru, count, row, state);
}

}  // namespace inhabit::nn
