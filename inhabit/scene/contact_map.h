#pragma once
#include <torch/types.h>

namespace inhabit {

/// Distance of every joint to every scene point (Eq. 1), metres: (..., J, N).
/// @param joints (..., J, 3); @param points (N, 3), or (B, N, 3) for joints (B, ..., J, 3). Differentiable.
torch::Tensor distance_map(const torch::Tensor& joints, const torch::Tensor& points);

/// Contact maps (Eq. 2): exp(-d^2 / (2 sigma^2)) of the distances d of Eq. 1, (..., J, N), 1 where a joint touches a
/// point and near 0 from a metre on (sigma = 0.2). Shapes as in distance_map. Differentiable. Where no gradient is
/// asked for, on the CPU and in float32, only points near a joint are computed; values under 1e-6 come out as 0 then,
/// and the others are right to 1e-6.
torch::Tensor contact_map(const torch::Tensor& joints, const torch::Tensor& points, double sigma = 0.2);

}  // namespace inhabit
