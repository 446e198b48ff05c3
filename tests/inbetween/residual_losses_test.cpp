// Protects the energy score that the denoiser is tuned by as it is deployed: least where samples are distributed as the
// truth is, with the value that normal distributions have.
#include "inhabit/inbetween/residual_losses.h"

#include <gtest/gtest.h>

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

double score(double mean, double deviation) {
  torch::manual_seed(1);
  const int64_t count = 400'000;
  const auto draw = [&] { return torch::randn({count, 1}, torch::kDouble); };
  const Tensor truth = draw(), a = mean + deviation * draw(), b = mean + deviation * draw();
  return energy_score(a, b, truth, 0).mean().item<double>();
}

TEST(EnergyScore, IsThatOfNormalDistributions) {
  // E|y - x| = 2 / sqrt(pi) of two standard normals: less half of the same.
  EXPECT_NEAR(score(0, 1), 1 / std::sqrt(M_PI), 3e-3);
  // All samples at 0: E|x| = sqrt(2 / pi).
  EXPECT_NEAR(score(0, 0), std::sqrt(2 / M_PI), 3e-3);
}

TEST(EnergyScore, IsLeastForTheTrueDistribution) {
  const double best = score(0, 1);
  for (const double deviation : {0.0, 0.5, 0.8, 1.3, 2.0}) EXPECT_GT(score(0, deviation), best + 3e-3) << deviation;
  for (const double mean : {-0.5, 0.3}) EXPECT_GT(score(mean, 1), best + 3e-3) << mean;
}

TEST(EnergyScore, HasGradientsWhereSamplesMeet) {
  Tensor a = torch::zeros({1, 3}), b = torch::zeros({1, 3});
  a.requires_grad_(true);
  b.requires_grad_(true);
  energy_score(a, b, torch::zeros({1, 3}), 0.05).sum().backward();
  EXPECT_TRUE(a.grad().isfinite().all().item<bool>());
}

}  // namespace
}  // namespace inhabit::inbetween
