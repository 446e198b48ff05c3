// Protects SLT*: that its parts take what those before them predict, that it sees the room, and that it learns.
#include "inhabit/forecast/slt_network.h"

#include <gtest/gtest.h>

#include "forecast/small_config.h"

namespace inhabit::forecast {
namespace {

using torch::Tensor;

Config small_config() {
  Config config = small_forecast_config();
  config.baselines.slt_goal = 24;
  config.baselines.slt_path = 6;
  config.baselines.slt_pose = 10;
  return config;
}

struct Slt : testing::Test {
  Slt() {
    torch::manual_seed(4);
    network = SltNetwork(config);
    network->eval();
    past = torch::randn({3, config.past, config.joints, 3});
    points = torch::randn({3, config.inference.points, 3});
  }
  const Config config = small_config();
  SltNetwork network{nullptr};
  Tensor past, points;
};

TEST_F(Slt, JointsAreThePosesMovedAlongThePathAndTheRootIsOnIt) {
  const torch::NoGradGuard no_gradients;
  const SltForecast f = network->forward(past, points);
  EXPECT_EQ(f.goal.sizes(), (std::vector<int64_t>{3, 3}));
  EXPECT_EQ(f.goal_pose.sizes(), (std::vector<int64_t>{3, config.joints, 3}));
  EXPECT_EQ(f.joints().sizes(), (std::vector<int64_t>{3, config.future, config.joints, 3}));
  EXPECT_TRUE(f.joints().select(2, config.root).equal(f.path));
  EXPECT_EQ(f.goal_pose.select(1, config.root).abs().max().item<double>(), 0);
  EXPECT_TRUE((f.joints() - f.path.unsqueeze(2)).allclose(f.local, 1e-5, 1e-6));
}

TEST_F(Slt, PathAndPosesFollowThePredictedGoal) {
  const torch::NoGradGuard no_gradients;
  const SltForecast before = network->forward(past, points);
  network->goal_net->parameters().back() += torch::tensor({1.F, 0.F, -2.F});  // the last layer's bias
  const SltForecast after = network->forward(past, points);
  EXPECT_TRUE((after.goal - before.goal).allclose(torch::tensor({1.F, 0.F, -2.F}).expand({3, 3}), 1e-4, 1e-5));
  EXPECT_FALSE(after.goal_pose.allclose(before.goal_pose, 1e-4, 1e-5));
  EXPECT_FALSE(after.path.allclose(before.path, 1e-4, 1e-5));
  EXPECT_FALSE(after.local.allclose(before.local, 1e-4, 1e-5));
}

TEST_F(Slt, SeesTheRoomWhateverTheOrderOfItsPoints) {
  const torch::NoGradGuard no_gradients;
  const Tensor joints = network->forward(past, points).joints();
  const Tensor other =
      network->forward(past, points.index_select(1, torch::randperm(config.inference.points))).joints();
  EXPECT_TRUE(other.allclose(joints, 1e-4, 1e-4));
  const Tensor flat = network->forward(past, points * torch::tensor({1.F, 0.1F, 1.F}) + 0.3 * points.square()).joints();
  EXPECT_FALSE(flat.allclose(joints, 1e-4, 1e-4));
}

TEST_F(Slt, OneWindowChangesNothingOfAnother) {
  const torch::NoGradGuard no_gradients;
  const Tensor all = network->forward(past, points).joints();
  const Tensor second = network->forward(past.slice(0, 1, 2), points.slice(0, 1, 2)).joints();
  EXPECT_TRUE(all.slice(0, 1, 2).allclose(second, 1e-4, 1e-5));
}

TEST_F(Slt, EveryWeightIsLearned) {
  network->train();
  const SltForecast f = network->forward(past, points);
  (f.goal.square().sum() + f.goal_pose.square().sum() + f.joints().square().sum()).backward();
  for (const auto& p : network->named_parameters()) {
    ASSERT_TRUE(p.value().grad().defined()) << p.key();
    // Instance norm takes away what a bias before it adds.
    const bool before_norm = p.key().starts_with("scene_points.") && p.key().ends_with(".bias");
    if (!before_norm) {
      EXPECT_GT(p.value().grad().abs().max().item<double>(), 0) << p.key();
    }
  }
}

}  // namespace
}  // namespace inhabit::forecast
