#pragma once
#include <torch/types.h>

/// Of any shape, at least one element; NaN where one of them is.
inline double largest(const torch::Tensor& x) { return x.abs().max().item<double>(); }

/// Of two tensors that broadcast, in double precision.
inline double largest_difference(const torch::Tensor& a, const torch::Tensor& b) {
  return largest(a.to(torch::kFloat64) - b.to(torch::kFloat64));
}
