// Protects the diffusion schedule: the cosine's closed form, the posterior against Bayes' rule on single numbers, and
// the forward process.
#include "inhabit/inbetween/schedule.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include <cmath>

namespace inhabit::inbetween {
namespace {

TEST(DiffusionSchedule, FollowsTheCosine) {
  const DiffusionSchedule s = cosine_schedule(1000);
  ASSERT_EQ(s.steps(), 1000);
  const auto level = [](double t) { return std::pow(std::cos((t / 1000 + 0.008) / 1.008 * std::acos(-1.0) / 2), 2); };
  int followed = 0;
  for (size_t t = 0; t < 1000; ++t) {
    EXPECT_GT(s.betas[t], 0);
    EXPECT_LE(s.betas[t], 0.999);
    if (s.betas[t] == 0.999) break;  // clipped from here on
    EXPECT_NEAR(s.alphas_cumprod[t] / (level(static_cast<double>(t) + 1) / level(0)), 1, 1e-9) << t;
    ++followed;
  }
  EXPECT_GE(followed, 998);
  EXPECT_LT(s.alphas_cumprod.back(), 1e-6);
}

TEST(DiffusionSchedule, PosteriorIsBayesRule) {
  const DiffusionSchedule s = cosine_schedule(40);
  const double x0 = 0.7, xt = -1.3;
  EXPECT_EQ(s.posterior_variance[0], 0);
  EXPECT_NEAR(s.posterior_mean_x0[0], 1, 1e-12);
  EXPECT_EQ(s.posterior_mean_xt[0], 0);
  for (size_t t = 1; t < 40; ++t) {
    // x_{t-1} given x_0, and x_t given x_{t-1}: the product of two normal densities.
    const double a = s.alphas_cumprod[t - 1], beta = s.betas[t];
    const double precision = 1 / (1 - a) + (1 - beta) / beta;
    const double mean = (std::sqrt(a) * x0 / (1 - a) + std::sqrt(1 - beta) * xt / beta) / precision;
    EXPECT_NEAR(s.posterior_variance[t] * precision, 1, 1e-9) << t;
    EXPECT_NEAR(s.posterior_mean_x0[t] * x0 + s.posterior_mean_xt[t] * xt, mean, 1e-9) << t;
  }
}

TEST(DiffusionSchedule, DiffusesEachSampleAtItsOwnStep) {
  const DiffusionSchedule s = cosine_schedule(100);
  const torch::Tensor x0 = torch::full({3, 2, 4}, 2.F), noise = torch::full({3, 2, 4}, -1.F);
  const torch::Tensor got = diffuse(s, x0, torch::tensor({0, 60, 99}), noise);
  const std::vector<size_t> steps = {0, 60, 99};
  for (int64_t b = 0; b < 3; ++b) {
    const double a = s.alphas_cumprod[steps[static_cast<size_t>(b)]];
    const double expected = 2 * std::sqrt(a) - std::sqrt(1 - a);
    EXPECT_LT((got[b] - expected).abs().max().item<double>(), 1e-6);
  }
}

}  // namespace
}  // namespace inhabit::inbetween
