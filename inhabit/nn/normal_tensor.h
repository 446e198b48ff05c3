#pragma once
#include <torch/types.h>

#include "inhabit/math/random.h"

namespace inhabit::nn {

/// Numbers from N(0, deviation^2), drawn row by row: the same on every machine.
inline torch::Tensor normal_tensor(std::mt19937_64& random, at::IntArrayRef shape, double deviation = 1) {
  torch::Tensor out = torch::empty(shape);
  float* value = out.data_ptr<float>();
  for (int64_t i = 0; i < out.numel(); ++i) value[i] = static_cast<float>(deviation * normal(random));
  return out;
}

}  // namespace inhabit::nn
