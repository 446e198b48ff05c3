// Protects standardisation: mean and deviation are those of all that was added, however it came, and networks see mean
// 0 and deviation 1.
#include "inhabit/nn/feature_scale.h"

#include <gtest/gtest.h>

#include "largest.h"

namespace inhabit {
namespace {

using torch::Tensor;

TEST(FeatureStatistics, AreThoseOfAllThatWasAdded) {
  torch::manual_seed(1);
  const Tensor features = torch::randn({60, 5}, torch::kFloat64) * torch::tensor({1.0, 2.0, 0.1, 5.0, 1e-3}) + 3;
  FeatureStatistics once, parts;
  once.add(features);
  parts.add(features.slice(0, 0, 20));
  parts.add(features.slice(0, 20).view({2, 20, 5}));
  for (const FeatureStatistics* statistics : {&once, &parts}) {
    const FeatureScale scale = statistics->scale();
    EXPECT_EQ(scale.mean.scalar_type(), torch::kFloat32);
    EXPECT_LT(largest_difference(scale.mean, features.mean(0)), 1e-6);
    EXPECT_LT(largest_difference(scale.deviation / features.std(0, /*unbiased=*/false), torch::ones({5})), 1e-5);
  }
}

TEST(FeatureStatistics, OfWhatNeverChangesHaveNoDeviation) {
  FeatureStatistics statistics;
  statistics.add(torch::full({7, 2}, 0.3));
  EXPECT_LT(largest(statistics.scale().deviation), 1e-6);
}

TEST(FeatureScale, NetworksSeeMean0AndDeviation1) {
  torch::manual_seed(2);
  const Tensor features = torch::randn({4, 500, 3}) * 7 - 2;
  FeatureStatistics statistics;
  statistics.add(features);
  const FeatureScale scale = statistics.scale();
  const Tensor x = scale.to_network(features), rows = x.flatten(0, 1);
  EXPECT_LT(largest(rows.mean(0)), 1e-5);
  EXPECT_LT(largest(rows.std(0, /*unbiased=*/false) - 1), 1e-5);
  EXPECT_LT(largest_difference(scale.from_network(x), features), 1e-5);
}

}  // namespace
}  // namespace inhabit
