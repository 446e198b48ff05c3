#pragma once
#include <torch/types.h>

namespace inhabit {

/// Distance of every joint to every scene point (Eq. 1), metres: (..., J, N).
/// @param joints (..., J, 3); @param points (N, 3), or (B, N, 3) for joints (B, ..., J, 3). Differentiable.
torch::Tensor distance_map(const torch::Tensor& joints, const torch::Tensor& points);

/// Contact maps (Eq. 2): exp(-d^2 / (2 sigma^2)) of the distances d of Eq. 1, (..., J, N), 1 where a joint touches a
/// point and near 0 from a metre on (sigma = 0.2). Shapes as in distance_map. Differentiable. Forecasting's features
/// are DCT coefficients of it, which forecast/contact_kernel finds without the map itself.
torch::Tensor contact_map(const torch::Tensor& joints, const torch::Tensor& points, double sigma = 0.2);

}  // namespace inhabit
