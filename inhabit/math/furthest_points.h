#pragma once
#include <torch/types.h>

namespace inhabit {

/// Indices (count) int64 of points (N, 3) each furthest from those chosen before it, beginning with `first`.
/// Throws Error when there are fewer points than asked for.
torch::Tensor furthest_point_indices(const torch::Tensor& points, int64_t count, int64_t first = 0);

}  // namespace inhabit
