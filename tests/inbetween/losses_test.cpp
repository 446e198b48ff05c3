// Protects Eq. 1-4: zero at the truth, each term sees what it is there for, and gradients are those of the values.
#include "inhabit/inbetween/losses.h"

#include <gtest/gtest.h>

#include "forecast/walker.h"
#include "inhabit/inbetween/features.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

struct Setting {
  Clip clip = walker(12, 1, 0.2, 1);
  Tensor mean, deviation, truth, bones;
  Config config = preset("features");
  Setting() {
    const Tensor features = clip_features(clip);
    mean = features.mean(0);
    deviation = features.std(0).clamp_min(0.01);
    truth = ((features - mean) / deviation).t().unsqueeze(0);
    bones = clip.skeleton.offsets.unsqueeze(0);
  }
  Tensor term(const Tensor& predicted, const std::string& name) const {
    for (const auto& [key, value] : loss_terms(predicted, truth, bones, {mean, deviation}, config))
      if (key == name) return value;
    ADD_FAILURE() << name;
    return {};
  }
};

TEST(InbetweenLosses, AreZeroAtTheTruth) {
  const Setting s;
  for (const char* name : {"simple", "joints", "velocity"})
    EXPECT_LT(s.term(s.truth, name).item<double>(), 1e-10) << name;
}

TEST(InbetweenLosses, AShiftOfTheRootIsOneOfAllJointsButNoVelocity) {
  const Setting s;
  Tensor shifted = s.truth.clone();
  shifted.select(1, 0).add_(0.6 / s.deviation[0]);  // 60 cm along x
  EXPECT_NEAR(s.term(shifted, "joints").item<double>(), 4.0 / 3, 1e-3)
      << "two units, squared, in one of three directions";
  EXPECT_LT(s.term(shifted, "velocity").item<double>(), 1e-6);
  const double simple = std::pow(0.6 / s.deviation[0].item<double>(), 2) / kFeatureCount;
  EXPECT_NEAR(s.term(shifted, "simple").item<double>(), simple, 1e-4 * simple);
  EXPECT_NEAR(s.term(shifted, "total").item<double>(), simple + s.config.training.joints_weight * 4.0 / 3, 1e-2);
}

TEST(InbetweenLosses, JitterIsVelocity) {
  const Setting s;
  Tensor shaken = s.truth.clone();
  const Tensor sign = torch::arange(12).remainder(2) * 2 - 1;
  shaken.select(1, 1).add_(0.03 / s.deviation[1] * sign);  // up and down by a tenth of a unit
  EXPECT_NEAR(s.term(shaken, "joints").item<double>(), 0.01 / 3, 1e-4);
  EXPECT_NEAR(s.term(shaken, "velocity").item<double>(), 0.04 / 3, 1e-4) << "two tenths a frame";
}

TEST(InbetweenLosses, StandingFeetThatMoveCost) {
  Setting s;
  s.truth = s.truth.slice(2, 0, 1).expand({-1, -1, 12}).contiguous();  // stands
  EXPECT_LT(s.term(s.truth, "feet").item<double>(), 1e-10);
  const Tensor slide = 0.006 / s.deviation[0] * torch::arange(12);
  Tensor sliding = s.truth.clone();
  sliding.select(1, 0).add_(slide);  // 6 mm a frame along x, a fiftieth of the unit
  EXPECT_NEAR(s.term(sliding, "feet").item<double>(), 0.0004 / 3, 1e-6);
  // Feet that move in truth may.
  for (int64_t x = kJointFeature; x < kFeatureCount; x += 3)
    s.truth.select(1, x).add_(0.012 / s.deviation[x] * torch::arange(12));
  EXPECT_EQ(s.term(s.truth, "feet").item<double>(), 0);
}

TEST(InbetweenLosses, GradientsAreThoseOfTheValues) {
  const Setting s;
  torch::manual_seed(4);
  const Tensor at = (s.truth + 0.3 * torch::randn_like(s.truth)).to(torch::kFloat64);
  const auto total = [&](const Tensor& x) {
    return loss_terms(x, s.truth.to(torch::kFloat64), s.bones.to(torch::kFloat64),
                      {s.mean.to(torch::kFloat64), s.deviation.to(torch::kFloat64)}, s.config)
        .front()
        .second;
  };
  const Tensor x = at.clone().requires_grad_(true);
  const Tensor slope = torch::autograd::grad({total(x)}, {x})[0];
  for (const int64_t feature : {0, 4, 20, 100, 150}) {
    Tensor step = torch::zeros_like(at);
    step[0][feature][5] = 1e-5;
    const double found = (total(at + step) - total(at - step)).item<double>() / 2e-5;
    EXPECT_NEAR(slope[0][feature][5].item<double>(), found, 1e-6 + 1e-5 * std::abs(found)) << feature;
  }
}

}  // namespace
}  // namespace inhabit::inbetween
