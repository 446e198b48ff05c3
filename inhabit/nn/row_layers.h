#pragma once
#include <torch/torch.h>

#include <vector>

#include "inhabit/nn/row_products_kernel.h"

namespace inhabit::nn {

/// A pointwise linear layer for inference over rows: y = x w + bias, batch norm folded in. Rows of y are w.stride()
/// apart, columns beyond w.out stay 0.
struct RowLayer {
  PackedMatrix w;
  std::vector<float> bias;  ///< w.stride() entries

  int64_t stride() const { return w.stride(); }
};

/// Scale and shift per channel that batch norm in evaluation mode applies.
struct FoldedNorm {
  torch::Tensor scale, shift;  ///< (C) float64
};
FoldedNorm folded_norm(const torch::nn::Module& batch_norm, double eps);

/// @param weight (out, in, 1...); @param bias (out) or undefined.
RowLayer row_layer(const torch::Tensor& weight, const torch::Tensor& bias);
/// The same with a batch norm behind it.
RowLayer row_layer(const torch::Tensor& weight, const torch::Tensor& bias, const FoldedNorm& norm);
/// A convolution as a product of `taps` rows that follow each other. @param weight (taps, in, out).
RowLayer row_layer_of_taps(const torch::Tensor& weight, const torch::Tensor& bias);

/// y[i] = bias + x[i] w for `count` rows.
void apply(const RowLayer& layer, const float* x, int64_t x_stride, int64_t count, float* y);

/// Gated recurrent unit over single rows (PyTorch's equations and gate order r, z, n), inference only.
struct RowGru {
  RowLayer from_input, from_state;  ///< (in, 3 hidden), (hidden, 3 hidden)
  int64_t hidden = 0;

  /// Halves of the gates that gru_update() joins, from one row: 3 hidden columns, `stride()` floats.
  void input_gates(const float* x, float* gates) const { apply(from_input, x, from_input.w.in, 1, gates); }
  void state_gates(const float* state, float* gates) const { apply(from_state, state, hidden, 1, gates); }
};
/// @param gru a torch::nn::GRU of one layer, or a GRUCell.
RowGru row_gru(const torch::nn::Module& gru);

/// Last state of a GRU over the rows of x (count, gru.from_input.w.in), from zero; `state` has gru.hidden floats.
void last_gru_state(const RowGru& gru, const float* x, int64_t count, float* state);
/// The same over encode(x) of every row (count, encode.w.in).
void last_gru_state(const RowLayer& encode, const RowGru& gru, const float* x, int64_t count, float* state);

}  // namespace inhabit::nn
