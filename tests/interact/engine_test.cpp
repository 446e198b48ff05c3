// Protects what people are moved by: our networks and each baseline give what plain evaluation gives of the same
// features, and a model that lacks one says so.
#include "inhabit/interact/engine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "inhabit/math/random.h"
#include "interact/small_networks.h"
#include "largest.h"
#include "refusal_of.h"

namespace inhabit::interact {
namespace {

using torch::Tensor;

class EnginePredictor : public testing::TestWithParam<Predictor> {};

TEST_P(EnginePredictor, GivesWhatPlainEvaluationOfTheSameFeaturesGives) {
  const torch::NoGradGuard no_gradients;
  const Networks n = untrained_networks(small_interact_config());
  const Engine engine(n, GetParam());
  Engine::Workspace work(engine, 5);
  const Tensor input = torch::randn({1, engine.input().size}), contacts = torch::randn({1, 8});
  std::copy_n(input.data_ptr<float>(), input.numel(), work.input.begin());
  std::copy_n(contacts.data_ptr<float>(), 8, work.contacts.begin());
  engine.predict(work);

  const Tensor row = rows_for(GetParam(), engine.input(), n.input_scale.to_network(input), contacts);
  std::mt19937_64 random(5);
  Tensor z = torch::empty({1, n.config.baselines.samp_z});
  for (int64_t i = 0; i < z.numel(); ++i) z.data_ptr<float>()[i] = static_cast<float>(normal(random));
  PoseNetwork pose = n.pose, nsm = n.nsm, nsm_control = n.nsm_control;
  SampNetwork samp = n.samp, samp_control = n.samp_control;
  const Tensor plain = GetParam() == Predictor::pose          ? pose->forward(row)
                       : GetParam() == Predictor::nsm         ? nsm->forward(row)
                       : GetParam() == Predictor::nsm_control ? nsm_control->forward(row)
                       : GetParam() == Predictor::samp        ? samp->decode(z, row)
                                                              : samp_control->decode(z, row);
  const Tensor output = torch::from_blob(work.output.data(), {1, engine.output().size});
  EXPECT_LT(largest(output - n.output_scale.from_network(plain)), 1e-3) << "16-bit weights";
}

INSTANTIATE_TEST_SUITE_P(All, EnginePredictor, testing::ValuesIn(kPredictors),
                         [](const auto& p) { return name_of(p.param); });

TEST(Engine, SaysWhatTheModelLacks) {
  Networks n = untrained_networks(small_interact_config());
  n.control = nullptr;
  n.samp = nullptr;
  EXPECT_THAT(refusal_of([&] { Engine e(n); }), testing::HasSubstr("lacks PoseNet or ControlNet"));
  EXPECT_THAT(refusal_of([&] { Engine e(n, Predictor::samp); }), testing::HasSubstr("the model lacks SAMP"));
  EXPECT_EQ(refusal_of([&] { Engine e(n, Predictor::nsm); }), "");
}

}  // namespace
}  // namespace inhabit::interact
