// Protects the distribution of latent codes: its divergence is the closed form, its samples have mean and deviation.
#include "inhabit/nn/latent_distribution.h"

#include <gtest/gtest.h>

#include <cmath>

#include "largest.h"

namespace inhabit::nn {
namespace {

TEST(LatentDistribution, DivergenceIsTheClosedForm) {
  EXPECT_DOUBLE_EQ((LatentDistribution{torch::zeros({2, 3}), torch::zeros({2, 3})}.divergence().item<double>()), 0);
  // KL(N(m, s^2) | N(0, 1)) = (m^2 + s^2 - 1) / 2 - log s
  const LatentDistribution q{torch::full({1, 2}, 2.0), torch::full({1, 2}, 2 * std::log(0.5))};
  EXPECT_NEAR(q.divergence().item<double>(), (4 + 0.25 - 1) / 2.0 - std::log(0.5), 1e-6);
  EXPECT_LT(largest_difference(q.sample(torch::ones({1, 2})), torch::full({1, 2}, 2.5)), 1e-6);
  // Mean 2, variance 9 in each of four numbers, twice.
  const LatentDistribution wide{torch::full({2, 4}, 2.0), torch::full({2, 4}, std::log(9.0))};
  EXPECT_NEAR(wide.summed_divergence().item<double>(), 4 * (4 + 9 - 1 - std::log(9.0)) / 2, 1e-5);
}

}  // namespace
}  // namespace inhabit::nn
