#include "inhabit/inbetween/schedule.h"

#include <torch/torch.h>

#include <algorithm>
#include <cmath>

namespace inhabit::inbetween {

using torch::Tensor;

DiffusionSchedule schedule_of(const std::vector<double>& betas) {
  DiffusionSchedule s;
  s.betas = betas;
  double before = 1;
  for (const double beta : betas) {
    const double now = before * (1 - beta);
    s.alphas_cumprod.push_back(now);
    s.posterior_variance.push_back(beta * (1 - before) / (1 - now));
    s.posterior_mean_x0.push_back(beta * std::sqrt(before) / (1 - now));
    s.posterior_mean_xt.push_back((1 - before) * std::sqrt(1 - beta) / (1 - now));
    before = now;
  }
  return s;
}

DiffusionSchedule cosine_schedule(int64_t steps) {
  const auto level = [&](int64_t t) {
    constexpr double kOffset = 0.008, kHalfPi = 1.5707963267948966;
    const double c =
        std::cos((static_cast<double>(t) / static_cast<double>(steps) + kOffset) / (1 + kOffset) * kHalfPi);
    return c * c;
  };
  std::vector<double> betas;
  for (int64_t t = 0; t < steps; ++t) betas.push_back(std::min(1 - level(t + 1) / level(t), 0.999));
  return schedule_of(betas);
}

Tensor diffuse(const DiffusionSchedule& schedule, const Tensor& x0, const Tensor& steps, const Tensor& noise) {
  const Tensor kept = torch::tensor(schedule.alphas_cumprod, torch::kFloat64).to(steps.device()).index_select(0, steps);
  std::vector<int64_t> shape(static_cast<size_t>(x0.dim()), 1);
  shape[0] = x0.size(0);
  return kept.sqrt().to(x0.scalar_type()).view(shape) * x0 + (1 - kept).sqrt().to(x0.scalar_type()).view(shape) * noise;
}

}  // namespace inhabit::inbetween
