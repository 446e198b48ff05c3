#pragma once
#include <torch/types.h>

#include <vector>

namespace inhabit::inbetween {

/// Variances of the forward process and coefficients of its posterior, by step 0 (least noise) to T - 1, in double.
struct DiffusionSchedule {
  std::vector<double> betas;               ///< in (0, 1), the variance that each step adds
  std::vector<double> alphas_cumprod;      ///< the running product of 1 - beta
  std::vector<double> posterior_variance;  ///< of q(x_{t-1} | x_t, x_0)
  std::vector<double> posterior_mean_x0;   ///< its mean is mean_x0 x_0 + mean_xt x_t
  std::vector<double> posterior_mean_xt;   ///< see posterior_mean_x0

  /// T, how many steps there are.
  int64_t steps() const { return static_cast<int64_t>(betas.size()); }
};

/// The cosine schedule (Nichol and Dhariwal 2021, Eq. 17): betas up to 0.999.
DiffusionSchedule cosine_schedule(int64_t steps);

/// A schedule of given betas, each in (0, 1).
DiffusionSchedule schedule_of(const std::vector<double>& betas);

/// x_t = sqrt(a_t) x_0 + sqrt(1 - a_t) noise, a being alphas_cumprod. @param x0, noise (B, ...). @param steps (B) int64
torch::Tensor diffuse(const DiffusionSchedule& schedule, const torch::Tensor& x0, const torch::Tensor& steps,
                      const torch::Tensor& noise);

}  // namespace inhabit::inbetween
