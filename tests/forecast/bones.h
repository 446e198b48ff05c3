#pragma once
#include <torch/types.h>

#include <vector>

#include "inhabit/body/skeleton.h"

/// Lengths (..., 21) of the standard skeleton's bones in joints (..., 22, 3).
inline torch::Tensor bone_lengths(const torch::Tensor& joints) {
  std::vector<torch::Tensor> out;
  for (int j = 1; j < inhabit::kStandardJoints; ++j)
    out.push_back(
        (joints.select(-2, j) - joints.select(-2, inhabit::standard_parents()[static_cast<size_t>(j)])).norm(2, {-1}));
  return torch::stack(out, -1);
}
