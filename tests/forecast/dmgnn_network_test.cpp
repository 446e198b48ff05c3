// Protects DMGNN: the three scales of the body, that the cell steps from the last observed joints, and who hears whom.
#include "inhabit/forecast/dmgnn_network.h"

#include <gmock/gmock.h>

#include "inhabit/body/skeleton.h"
#include "refusal_of.h"

namespace inhabit::forecast {
namespace {

using torch::Tensor;

struct Dmgnn : testing::Test {
  Dmgnn() {
    torch::manual_seed(4);
    config = preset("compact");
    config.past = 9;
    config.future = 5;
    config.baselines.dmgnn_width = 3;
    network = DmgnnNetwork(config);
    network->eval();
    past = torch::randn({2, config.past, kStandardJoints, 3});
  }
  /// The last layer of what makes steps says `metres` whatever it sees.
  void step_always(const Tensor& metres) {
    const torch::NoGradGuard no_gradients;
    auto parameters = network->step->parameters();
    parameters[parameters.size() - 2].zero_();
    parameters.back().copy_(metres);
  }
  Config config;
  DmgnnNetwork network{nullptr};
  Tensor past;
};

TEST_F(Dmgnn, PartsAreMeansOfAllJointsAndNeighboursOnATree) {
  const std::vector<BodyScale> scales = body_scales();
  ASSERT_EQ(scales.size(), 3U);
  const int64_t parts[] = {22, 10, 5};
  for (size_t s = 0; s < 3; ++s) {
    const BodyScale& scale = scales[s];
    EXPECT_EQ(scale.members.sizes(), (std::vector<int64_t>{parts[s], kStandardJoints}));
    EXPECT_TRUE(scale.members.sum(1).allclose(torch::ones({parts[s]})));
    EXPECT_TRUE((scale.members > 0).sum(0).eq(1).all().item<bool>()) << "every joint is of one part";
    EXPECT_TRUE(scale.adjacency.sum(0).sum(0).allclose(torch::ones({parts[s]})));
    const Tensor neighbours = scale.adjacency[1] > 0;
    EXPECT_TRUE(neighbours.equal(neighbours.t()));
    EXPECT_EQ(neighbours.sum().item<int64_t>(), 2 * (parts[s] - 1)) << "a tree";
    Tensor reached = torch::matrix_power(torch::eye(parts[s]) + neighbours.to(torch::kFloat), parts[s]);
    EXPECT_TRUE((reached > 0).all().item<bool>()) << "in one piece";
  }
  ASSERT_EQ(standard_joint_names()[10], "left_foot");
  for (const size_t scale : {1U, 2U})
    EXPECT_TRUE(scales[scale].members.select(1, 10).equal(scales[scale].members.select(1, 7))) << "with the ankle";
}

TEST_F(Dmgnn, StepsAddUpFromTheLastObservedJoints) {
  const torch::NoGradGuard no_gradients;
  const Tensor last = past.select(1, config.past - 1);
  step_always(torch::zeros({3}));
  EXPECT_TRUE(network->forward(past).equal(last.unsqueeze(1).expand({-1, config.future, -1, -1})));
  const Tensor step = torch::tensor({0.1F, 0.F, -0.2F});
  step_always(step);
  const Tensor joints = network->forward(past);
  for (int64_t t = 0; t < config.future; ++t)
    EXPECT_TRUE(joints.select(1, t).allclose(last + step * static_cast<double>(t + 1), 1e-5, 1e-5)) << t;
}

TEST_F(Dmgnn, AHandIsHeardByAFootAndOneWindowByNoOther) {
  const torch::NoGradGuard no_gradients;
  const Tensor joints = network->forward(past);
  EXPECT_EQ(joints.sizes(), (std::vector<int64_t>{2, config.future, kStandardJoints, 3}));
  Tensor moved = past.clone();
  moved[0].slice(0, 0, config.past - 3).select(1, 20) += 0.5;  // the left wrist, long ago
  const Tensor change = (network->forward(moved) - joints).abs();
  EXPECT_GT(change[0].select(1, 11).max().item<double>(), 1e-7) << "the right foot";
  EXPECT_EQ(change[1].max().item<double>(), 0);
}

TEST_F(Dmgnn, EveryWeightIsLearned) {
  network->train();
  network->forward(past).square().sum().backward();
  for (const auto& p : network->named_parameters())
    EXPECT_TRUE(p.value().grad().defined() && p.value().grad().isfinite().all().item<bool>()) << p.key();
}

TEST_F(Dmgnn, RefusesOtherSkeletonsAndTooShortPasts) {
  Config other = config;
  other.joints = 17;
  EXPECT_THAT(refusal_of([&] { DmgnnNetwork refused(other); }), testing::HasSubstr("needs the standard 22 joints"));
  other = config;
  other.past = 2;
  EXPECT_THAT(refusal_of([&] { DmgnnNetwork refused(other); }), testing::HasSubstr("three observed frames"));
}

}  // namespace
}  // namespace inhabit::forecast
