#pragma once
#include <torch/types.h>

#include <cstdint>
#include <vector>

#include "inhabit/inbetween/keyframes.h"

namespace inhabit::inbetween {

/// (T, groups) in which whole poses are given at `keys`.
inline torch::Tensor whole_keys(int64_t frames, const std::vector<int64_t>& keys) {
  torch::Tensor out = torch::zeros({frames, kKeyGroups});
  for (const int64_t key : keys) out[key].fill_(1);
  return out;
}

}  // namespace inhabit::inbetween
