#pragma once
#include <torch/types.h>

#include <cmath>

#include "inhabit/math/random.h"

namespace inhabit::nn {

// Numbers drawn row by row: the same on every machine.

/// From N(0, deviation^2).
inline torch::Tensor normal_tensor(std::mt19937_64& random, at::IntArrayRef shape, double deviation = 1) {
  torch::Tensor out = torch::empty(shape);
  float* value = out.data_ptr<float>();
  for (int64_t i = 0; i < out.numel(); ++i) value[i] = static_cast<float>(deviation * normal(random));
  return out;
}

/// From the standard Gumbel distribution: the largest of log-probabilities with these added is a draw from them.
inline float gumbel(std::mt19937_64& random) {
  return static_cast<float>(-std::log(-std::log(uniform(random, 0x1.0p-53, 1))));
}

/// From the standard Gumbel distribution.
inline torch::Tensor gumbel_tensor(std::mt19937_64& random, at::IntArrayRef shape) {
  torch::Tensor out = torch::empty(shape);
  float* value = out.data_ptr<float>();
  for (int64_t i = 0; i < out.numel(); ++i) value[i] = gumbel(random);
  return out;
}

}  // namespace inhabit::nn
