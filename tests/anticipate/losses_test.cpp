// Protects the losses of Eq. 4, 5, 7 and 8: small cases by hand, and their gradients against finite differences.
#include "inhabit/anticipate/losses.h"

#include <gtest/gtest.h>

#include <cmath>

#include "inhabit/anticipate/network.h"

namespace inhabit::anticipate {
namespace {

using torch::Tensor;

FeatureScale plain_scale() { return {torch::zeros({67}), torch::ones({67})}; }

TEST(ReconstructionWeights, FallFromOneAtTheLastObservedFrameToZero) {
  // lambda(t) = 1, lambda(t + 4) = 0: the frames t+1 to t+6.
  EXPECT_TRUE(torch::allclose(reconstruction_weights(6, 4), torch::tensor({0.75F, 0.5F, 0.25F, 0.F, 0.F, 0.F})));
  EXPECT_TRUE(torch::equal(reconstruction_weights(3, 0), torch::ones({3}))) << "never fades";
}

TEST(PoseReconstruction, IsTheMeanDistanceInMetres) {
  // Frame 0: one joint is off by (3, 4, 0) cm, weight 1; frame 1: one by 2 cm, weight 0.5. 2 frames, 21 joints.
  torch::manual_seed(1);
  const Tensor truth = torch::randn({1, 2, 67});
  Tensor forecast = truth.clone();
  forecast[0][0][12] += 0.3, forecast[0][0][13] += 0.4, forecast[0][1][62] += 0.2;
  forecast[0][0][66] += 9;  // of the root motion
  FeatureScale scale = plain_scale();
  scale.deviation = scale.deviation * 0.1;
  const Tensor weights = torch::tensor({1.F, 0.5F}).unsqueeze(0);
  EXPECT_NEAR(pose_reconstruction_loss(forecast, truth, weights, scale).item<double>(), (0.05 + 0.5 * 0.02) / 42, 2e-6);
  EXPECT_NEAR(pose_reconstruction_loss(forecast, truth, torch::zeros({1, 2}), scale).item<double>(), 0, 1e-9);
}

TEST(RootReconstruction, IsTheMeanErrorOfItsFourNumbers) {
  const Tensor truth = torch::zeros({1, 2, 67});
  Tensor forecast = truth.clone();
  forecast[0][0][63] = 1, forecast[0][0][66] = -3, forecast[0][1][64] = 2;
  forecast[0][1][10] = 7;  // of the pose
  const Tensor weights = torch::tensor({1.F, 0.5F}).unsqueeze(0);
  EXPECT_NEAR(root_reconstruction_loss(forecast, truth, weights).item<double>(), (4.0 / 4 + 0.5 * 2 / 4) / 2, 1e-6);
}

TEST(IntentionLoss, IsTheCrossEntropyOverRecordedFrames) {
  // Probabilities 1/2, 1/4, 1/4, then 1/10, 9/10, 0, then a frame that was not recorded.
  const Tensor logits = torch::tensor({0.5F, 0.25F, 0.25F, 0.1F, 0.9F, 1e-9F, 1.F, 1.F, 1.F}).log().view({1, 3, 3});
  const Tensor labels = torch::tensor({0, 0, 2}).view({1, 3}), weights = torch::tensor({1.F, 1.F, 0.F}).view({1, 3});
  EXPECT_NEAR(intention_loss(logits, labels, weights).item<double>(), (std::log(2) + std::log(10)) / 2, 1e-5);
  EXPECT_EQ(intention_loss(logits, labels, torch::zeros({1, 3})).item<double>(), 0) << "no frame, no loss";
}

TEST(AdversarialLosses, AreThoseOfProbabilities) {
  // Taken for real with probability 0.8 and 0.5 (real input), 0.25 (forecast).
  const auto logit = [](double p) { return std::log(p / (1 - p)); };
  const Tensor real = torch::tensor({logit(0.8), logit(0.5)}), forecast = torch::tensor({logit(0.25)});
  EXPECT_NEAR(discriminator_loss(real, forecast).item<double>(),
              -(std::log(0.8) + std::log(0.5)) / 2 - std::log(1 - 0.25), 1e-6);
  EXPECT_NEAR(generator_loss(forecast).item<double>(), -std::log(0.25), 1e-6);
  const Tensor sure = torch::tensor({200.F});
  EXPECT_NEAR(discriminator_loss(sure, -sure).item<double>(), 0, 1e-6);
  EXPECT_NEAR(generator_loss(-sure).item<double>(), 200, 1e-3) << "no logarithm of zero";
}

TEST(SamenessLoss, IsTheFractionThatThePosesDistanceLacks) {
  Tensor a = torch::zeros({2, 3, 67}), b = torch::zeros({2, 3, 67});
  b.select(2, 5) = 0.3, b.select(2, 9) = 0.4;  // 0.5 m apart in every frame
  b.slice(2, 63) = 5;                          // another root motion counts for nothing
  b[1].slice(1, 0, 63) = 9;                    // further apart than is asked for
  const Tensor enough = torch::tensor({2.F, 4.F});
  EXPECT_NEAR(diversity_loss(a, b, plain_scale(), enough).item<double>(), (0.75 + 0) / 2, 1e-5);
  EXPECT_NEAR(diversity_loss(a, a, plain_scale(), enough).item<double>(), 1, 1e-4);
}

TEST(PoseSpread, IsTheDistanceOfPosesAThirdOfTheTimeApart) {
  Tensor still = torch::zeros({6, 67}), moving = torch::zeros({6, 67});
  moving.select(1, 4) = torch::tensor({0.F, 0.F, 0.3F, 0.3F, 0.6F, 0.6F});  // 0.3, 0.3 and, round the end, 0.6 m
  moving.select(1, 64) = torch::arange(6).to(torch::kFloat32);              // the root motion counts for nothing
  const Tensor spread = pose_spread(torch::stack({still, moving}), plain_scale());
  EXPECT_NEAR(spread[0].item<double>(), 0, 1e-4);
  EXPECT_NEAR(spread[1].item<double>(), 0.4, 1e-4);
}

TEST(Losses, GradientsAreThoseOfFiniteDifferences) {
  torch::manual_seed(3);
  const auto exact = torch::kFloat64;
  const Tensor truth = torch::randn({2, 3, 67}, exact), weights = torch::rand({2, 3}, exact),
               labels = torch::randint(0, 67, {2, 3}, torch::kInt64), other = torch::randn({2, 3, 67}, exact);
  const FeatureScale scale{torch::zeros({67}, exact), torch::rand({67}, exact) + 0.5};
  const std::vector<std::pair<const char*, std::function<Tensor(const Tensor&)>>> losses = {
      {"pose", [&](const Tensor& x) { return pose_reconstruction_loss(x, truth, weights, scale); }},
      {"root", [&](const Tensor& x) { return root_reconstruction_loss(x, truth, weights); }},
      {"intention", [&](const Tensor& x) { return intention_loss(x, labels, weights); }},
      {"discriminator", [&](const Tensor& x) { return discriminator_loss(x.select(2, 3), x.select(2, 4)); }},
      {"generator", [&](const Tensor& x) { return generator_loss(x.select(2, 4)); }},
      {"sameness", [&](const Tensor& x) { return diversity_loss(x, other, scale, torch::full({2}, 100.0)); }}};
  for (const auto& [name, loss] : losses) {
    const Tensor x = torch::randn({2, 3, 67}, exact).requires_grad_(true), direction = torch::randn({2, 3, 67}, exact);
    const Tensor slope = torch::autograd::grad({loss(x)}, {x})[0];
    const double step = 1e-6,
                 measured = (loss(x + step * direction) - loss(x - step * direction)).item<double>() / (2 * step);
    EXPECT_GT(std::abs(measured), 1e-5) << name;
    EXPECT_NEAR((slope * direction).sum().item<double>(), measured, 1e-5 * std::abs(measured) + 1e-8) << name;
  }
  const Tensor same = truth.clone().requires_grad_(true);  // a distance of zero has no slope, and no NaN
  EXPECT_TRUE(torch::autograd::grad({pose_reconstruction_loss(same, truth, weights, scale)}, {same})[0]
                  .isfinite()
                  .all()
                  .item<bool>());
}

}  // namespace
}  // namespace inhabit::anticipate
