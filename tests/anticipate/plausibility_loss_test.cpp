// Protects the loss that stands for NDMS in training: a recording counts as plausible as the other recordings of its
// action find it, never as it finds itself, and the gradient is that of the score.
#include "inhabit/anticipate/plausibility_loss.h"

#include <gtest/gtest.h>

#include "anticipate/people.h"
#include "inhabit/metrics/ndms.h"
#include "largest.h"

namespace inhabit::anticipate {
namespace {

using torch::Tensor;

constexpr int64_t kKappa = 8;
constexpr double kSharp = 1e-5;  // metres a frame: nothing is rounded off

/// Every word of one window.
Tensor all_starts(int64_t frames) { return torch::arange(frames - kKappa + 1).unsqueeze(0); }

double loss_of(const PlausibilityLoss& loss, const Tensor& features, int64_t action) {
  return loss(features.unsqueeze(0), torch::tensor({action}), all_starts(features.size(0))).item<double>();
}

Tensor words_of(const Sequence& s) {
  return torch::cat({pose_words(feature_poses(s.features), kKappa),
                     pose_words(feature_poses(mirrored_features(s.features)), kKappa)});
}

TEST(PlausibilityLoss, OfARecordingIsNdmsBesideTheOther) {
  const std::vector<Sequence> all = people(60);  // two walk, two wave
  const PlausibilityLoss loss(all, kKappa, kSharp);
  EXPECT_EQ(action_names(all), (std::vector<std::string>{"walk", "wave"}));
  for (const size_t i : {0U, 1U}) {
    const Tensor words = pose_words(feature_poses(all[i].features), kKappa);
    const double ndms_of = plausibility(words, WordIndex(words_of(all[1 - i]))).mean().item<double>();
    ASSERT_LT(ndms_of, 0.999) << "the recordings differ";
    EXPECT_NEAR(loss_of(loss, all[i].features, 0), 1 - ndms_of, 0.005);
  }
  EXPECT_GT(loss_of(loss, all[0].features, 1), loss_of(loss, all[0].features, 0) + 0.1) << "walking is not waving";
}

TEST(PlausibilityLoss, OfAnActionWithOneRecordingIsBesideThatOne) {
  const std::vector<Sequence> one = {people(60).front()};
  const Tensor words = pose_words(feature_poses(one[0].features), kKappa);
  EXPECT_NEAR(loss_of(PlausibilityLoss(one, kKappa, kSharp), one[0].features, 0),
              1 - ndms(words, words).mean().item<double>(), 0.005)
      << "joints at rest score 0";
}

TEST(PlausibilityLoss, LooksAtTheWordsThatItIsTold) {
  const std::vector<Sequence> all = people(60);
  const PlausibilityLoss loss(all, kKappa);
  Tensor features = all[0].features.clone();
  features.slice(0, 30).copy_(features.slice(0, 29, 30).expand({30, -1}));  // stands still from frame 29 on
  const auto at = [&](int64_t start) {
    return loss(features.unsqueeze(0), torch::tensor({0}), torch::tensor({{start}})).item<double>();
  };
  EXPECT_GT(at(40), at(10) + 0.2);
}

TEST(PlausibilityLoss, HasItsFiniteDifferencesAsGradient) {
  const std::vector<Sequence> all = people(60);
  const PlausibilityLoss loss(all, kKappa);
  torch::manual_seed(3);
  const Tensor features = (all[0].features.slice(0, 0, 20) + 0.02 * torch::randn({20, kFeatureCount})).unsqueeze(0);
  const Tensor starts = torch::tensor({{0, 5, 12}}), action = torch::tensor({0});
  Tensor x = features.clone().requires_grad_(true);
  const Tensor gradient = torch::autograd::grad({loss(x, action, starts)}, {x})[0];
  const Tensor direction = torch::randn_like(features);
  constexpr double kStep = 2e-4;
  const double change =
      (loss(features + kStep * direction, action, starts) - loss(features - kStep * direction, action, starts))
          .item<double>() /
      (2 * kStep);
  EXPECT_NEAR((gradient * direction).sum().item<double>(), change, 0.05 * std::abs(change) + 1e-3);
}

TEST(PlausibilityLoss, HasAFiniteGradientWhereNobodyMoves) {
  const std::vector<Sequence> all = people(60);
  const Tensor still = all[0].features.slice(0, 0, 1).expand({20, -1}).unsqueeze(0);
  Tensor x = still.clone().requires_grad_(true);
  const Tensor loss = PlausibilityLoss(all, kKappa)(x, torch::tensor({0}), torch::tensor({{0, 6}}));
  EXPECT_TRUE(torch::autograd::grad({loss}, {x})[0].isfinite().all().item<bool>());
}

}  // namespace
}  // namespace inhabit::anticipate
