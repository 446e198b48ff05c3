// Protects the hypotheses: ways to go on that leave from the last pose on the person's own bones, their errors against
// the one forecast's losses, and a training that finds two futures where the mean finds neither.
#include "inhabit/forecast/hypotheses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "forecast/bones.h"
#include "forecast/walker_data.h"
#include "inhabit/forecast/contact_forecaster.h"
#include "inhabit/forecast/losses.h"
#include "inhabit/forecast/model_file.h"
#include "largest.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit::forecast {
namespace {

using ::testing::HasSubstr;
using torch::Tensor;

Config small_hypotheses(int many) {
  Config c = preset("compact");
  c.articulated.width = 24;
  c.articulated.blocks = 1;
  c.articulated.hypotheses = many;
  return c;
}

struct Model {
  Config config;
  ArticulatedNetwork articulated{nullptr};
  HypothesesNetwork hypotheses{nullptr};

  explicit Model(int many) : config(small_hypotheses(many)) {
    torch::manual_seed(4);
    articulated = ArticulatedNetwork(config);
    hypotheses = HypothesesNetwork(config);
  }
  ArticulatedNetworkImpl::Seen see(const Tensor& past) {
    const torch::NoGradGuard no_gradients;
    const Tensor points = torch::zeros({past.size(0), config.future, kStandardJoints, 4});
    return articulated->see(past, points, contact_conditioning(past.size(0), false, false));
  }
  Tensor forecast(const Tensor& past) {
    const Tensor points = torch::zeros({past.size(0), config.future, kStandardJoints, 4});
    return forecast_joints(articulated->forward(past, points, contact_conditioning(past.size(0), false, false)), 0);
  }
};

/// Somebody who walks, origin at the last root.
Tensor one_past() {
  const Tensor past = walker(30, 1.2, 0, 1).joints.unsqueeze(0);
  return past - past.slice(1, 29).slice(2, 0, 1);
}

TEST(Hypotheses, LeaveFromTheLastPoseOnThePersonsOwnBones) {
  const torch::NoGradGuard no_gradients;
  Model m(3);
  m.hypotheses->out->weight.normal_(0, 0.1);
  const Tensor past = one_past();
  const Hypotheses found = m.hypotheses->forward(m.articulated, m.see(past));
  ASSERT_EQ(found.joints.sizes(), torch::IntArrayRef({1, 3, 60, 22, 3}));
  EXPECT_NEAR(found.log_probability.exp().sum().item<double>(), 1, 1e-5);
  const Tensor last = past.select(1, 29);
  EXPECT_LT(largest(bone_lengths(found.joints) - bone_lengths(last)), 1e-4);
  EXPECT_LT(largest(found.joints.select(2, 0) - m.forecast(past).select(1, 0).unsqueeze(1)), 0.1)
      << "the gate is all but shut";
  EXPECT_GT(largest(found.joints[0][0] - found.joints[0][1]), 0.05) << "they differ";
}

TEST(Hypotheses, AreTheOneForecastWhereNothingIsAdded) {
  const torch::NoGradGuard no_gradients;
  Model m(2);
  m.articulated->out->weight.normal_(0, 0.3);
  m.hypotheses->out->weight.zero_();
  const Tensor past = one_past();
  const Hypotheses found = m.hypotheses->forward(m.articulated, m.see(past));
  for (int64_t k = 0; k < 2; ++k) EXPECT_LT(largest(found.joints.select(1, k) - m.forecast(past)), 1e-5);
}

TEST(Hypotheses, ErrorsAreTheLossesOfTheOneForecast) {
  const torch::NoGradGuard no_gradients;
  Config c = small_hypotheses(2);
  c.training.root_weight = 2;
  c.training.velocity_weight = 3;
  c.training.contact_weight = 0;
  torch::manual_seed(5);
  const Tensor future = torch::randn({1, 60, 22, 3}), last = torch::randn({1, 22, 3}),
               guess = torch::randn({1, 2, 60, 22, 3});
  const Tensor errors = hypothesis_errors(guess, last, future, c);
  for (int64_t k = 0; k < 2; ++k) {
    const Tensor path = guess.select(1, k).select(2, 0);
    const MotionForecast forecast{torch::cat({torch::zeros({1, 30, 3}), path}, 1),
                                  guess.select(1, k) - path.unsqueeze(2)};
    const ArticulatedLosses l = articulated_losses(forecast, last, future, torch::zeros({1, 60, 22, 4}), c);
    EXPECT_NEAR(errors[0][k].item<double>(), l.total.item<double>(), 1e-4);
  }
}

TEST(Hypotheses, FindTwoFuturesWhereTheMeanFindsNeither) {
  Model m(2);
  const Tensor past = one_past().expand({2, -1, -1, -1}).contiguous(), last = past.select(1, 29);
  // Who goes on to the left or to the right, with equal chance.
  Tensor future = m.forecast(past).detach().clone();
  const Tensor aside = torch::linspace(0, 1, 60).square().view({60, 1});
  future[0].select(2, 0).add_(aside);
  future[1].select(2, 0).sub_(aside);
  const ArticulatedNetworkImpl::Seen seen = m.see(past);
  torch::optim::Adam optimizer(m.hypotheses->parameters(), 5e-3);
  const auto errors = [&] {
    return hypothesis_errors(m.hypotheses->forward(m.articulated, seen).joints, last, future, m.config);
  };
  for (int step = 0; step < 150; ++step) {
    const Tensor all = errors();
    const Tensor loss = 0.97 * all.amin(1).mean() + 0.03 * all.mean();
    optimizer.zero_grad();
    loss.backward();
    optimizer.step();
  }
  const torch::NoGradGuard no_gradients;
  const Tensor after = errors();
  const double middle = hypothesis_errors(m.forecast(past).unsqueeze(1), last, future, m.config).mean().item<double>();
  EXPECT_LT(after.amin(1).mean().item<double>(), 0.3 * middle);
  EXPECT_NE(after[0].argmin().item<int64_t>(), after[1].argmin().item<int64_t>()) << "one each";
}

TEST(Hypotheses, AreKeptInTheModelFile) {
  const torch::NoGradGuard no_gradients;
  const TempFolder folder;
  Model m(2);
  Networks saved;
  saved.config = m.config;
  saved.articulated = m.articulated;
  save_networks(folder / "none.safetensors", saved);
  EXPECT_TRUE(load_networks(folder / "none.safetensors").hypotheses.is_empty());
  saved.hypotheses = m.hypotheses;
  save_networks(folder / "m.safetensors", saved);
  Networks loaded = load_networks(folder / "m.safetensors");
  ASSERT_FALSE(loaded.hypotheses.is_empty());
  const Tensor past = one_past();
  EXPECT_TRUE(torch::equal(loaded.hypotheses->forward(loaded.articulated, m.see(past)).joints,
                           m.hypotheses->forward(m.articulated, m.see(past)).joints));
  SafeTensors bad = read_safetensors(folder / "m.safetensors");
  Config without = m.config;
  without.articulated.hypotheses = 0;
  bad.metadata["config"] = to_json(without);
  write_safetensors(folder / "m.safetensors", bad);
  EXPECT_THAT(refusal_of([&] { load_networks(folder / "m.safetensors"); }), HasSubstr("hypotheses"));
}

TEST(Hypotheses, ShippedOnesAreOrderedAndAsManyAsAsked) {
  const auto forecaster = ContactForecaster::load(INHABIT_SOURCE_DIR "/models/forecast-compact.safetensors");
  ASSERT_EQ(forecaster.hypotheses(), 5);
  const Clip clip = walker(45, 1.2, 0.3, 1);
  Options options;
  options.samples = 3;
  options.refine = false;
  const Result r = forecaster.run(clip, scanned_room(2000), options);
  ASSERT_EQ(r.hypotheses.size(), 3U);
  double before = 1, sum = 0;
  for (const Hypothesis& one : r.hypotheses) {
    EXPECT_LE(one.probability, before);
    before = one.probability;
    sum += one.probability;
    EXPECT_EQ(one.prediction.frames(), 60);
    EXPECT_EQ(one.on_source.frames(), 60);
    EXPECT_LT((one.joints[0] - r.past.joints[29]).norm(2, {1}).max().item<double>(), 0.15) << "goes on from there";
  }
  EXPECT_LE(sum, 1 + 1e-6);
  EXPECT_GT(largest(r.hypotheses[0].joints - r.hypotheses[1].joints), 0.02);
  options.samples = 1;
  EXPECT_TRUE(torch::equal(forecaster.run(clip, scanned_room(2000), options).prediction.joints, r.prediction.joints))
      << "the one forecast stays as it is";
  options.samples = 6;
  EXPECT_THAT(refusal_of([&] { forecaster.run(clip, scanned_room(2000), options); }), HasSubstr("5 ways to go on"));
}

}  // namespace
}  // namespace inhabit::forecast
