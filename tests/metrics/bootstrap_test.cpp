// Protects intervals by bootstrap: they are those of known distributions, cancel what two sets share, and follow from
// the seed alone.
#include "inhabit/metrics/bootstrap.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "inhabit/math/random.h"
#include "refusal_of.h"

namespace inhabit {
namespace {

using torch::Tensor;

Tensor draws(int64_t count, double mean, double deviation, uint64_t seed) {
  std::mt19937_64 random(seed);
  Tensor out = torch::empty({count}, torch::kDouble);
  for (int64_t i = 0; i < count; ++i) out.data_ptr<double>()[i] = normal(random, mean, deviation);
  return out;
}

TEST(BootstrapCounts, DrawAsManyAsThereAreWithReplacement) {
  const Tensor counts = bootstrap_counts(50, 2000, 7);
  EXPECT_EQ(counts.sizes(), (std::vector<int64_t>{2000, 50}));
  EXPECT_EQ((counts.sum(1) - 50).abs().max().item<double>(), 0);
  EXPECT_EQ(counts.min().item<double>(), 0);
  EXPECT_NEAR(counts.mean(0).min().item<double>(), 1, 0.1);
  // How often an item is drawn is binomial: 50 draws of probability 1/50, a variance of 1 - 1/50; some 36 % are left
  // out.
  EXPECT_NEAR(counts.var().item<double>(), 0.98, 0.02);
  EXPECT_NEAR((counts == 0).to(torch::kDouble).mean().item<double>(), std::pow(0.98, 50), 0.01);
  EXPECT_TRUE(counts.equal(bootstrap_counts(50, 2000, 7)));
  EXPECT_FALSE(counts.equal(bootstrap_counts(50, 2000, 8)));
  for (const auto& [items, resamples] : {std::pair<int64_t, int64_t>{0, 1}, {1, 0}})
    EXPECT_THAT(refusal_of([&, i = items, r = resamples] { bootstrap_counts(i, r, 1); }),
                testing::HasSubstr("bootstrap"));
}

TEST(HalfInterval, IsHalfOfTheMiddle95PerCent) {
  std::vector<double> even;
  for (int i = 1000; i >= 0; --i) even.push_back(i);
  EXPECT_NEAR(half_interval(even), 0.95 * 1000 / 2, 1e-9);
  even.push_back(NAN);
  EXPECT_NEAR(half_interval(even), 0.95 * 1000 / 2, 1e-9);
  EXPECT_EQ(half_interval({3}), 0);
  EXPECT_EQ(half_interval({}), 0);
}

TEST(ResampledRatios, HaveTheIntervalOfTheMean) {
  const int64_t n = 400;
  const Tensor values = draws(n, 5, 2, 1), ones = torch::ones({n}, torch::kDouble),
               counts = bootstrap_counts(n, 4000, 2);
  const double expected = 1.96 * values.std().item<double>() / std::sqrt(static_cast<double>(n));
  EXPECT_NEAR(half_interval(resampled_ratios(values, ones, counts)), expected, 0.07 * expected);
  // Weights count: a ratio of sums, not a mean of ratios.
  Tensor weights = ones.clone();
  weights.slice(0, 0, n / 2).zero_();
  const auto half = resampled_ratios(values * weights, weights, counts);
  EXPECT_NEAR(half_interval(half), expected * std::sqrt(2), 0.15 * expected);
  for (const double none : resampled_ratios(values, torch::zeros_like(ones), counts)) ASSERT_TRUE(std::isnan(none));
}

TEST(ResampledRatios, OfPairsCancelWhatTheyShare) {
  const int64_t n = 300;
  const Tensor shared = draws(n, 0, 10, 3), ones = torch::ones({n}, torch::kDouble),
               counts = bootstrap_counts(n, 2000, 4);
  const Tensor small = draws(n, 1, 0.1, 5);
  const auto a = resampled_ratios(shared, ones, counts), b = resampled_ratios(shared + small, ones, counts);
  std::vector<double> difference(a.size());
  for (size_t i = 0; i < a.size(); ++i) difference[i] = b[i] - a[i];
  EXPECT_GT(half_interval(a), 1);
  EXPECT_NEAR(half_interval(difference), 1.96 * 0.1 / std::sqrt(300.), 0.002);
}

}  // namespace
}  // namespace inhabit
