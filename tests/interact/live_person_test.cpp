// Protects when somebody has arrived at a place on the floor by networks that are known: they say that the person walks
// and stands where they are. Then walking there has failed, and the person is to stay and not to drift off.
// And what is known of somebody who was seen before they are moved.
#include "inhabit/interact/live_person.h"

#include <gtest/gtest.h>

#include "inhabit/interact/layout.h"
#include "inhabit/interact/recording.h"
#include "inhabit/io/files.h"
#include "inhabit/motion/retarget.h"
#include "small_networks.h"

namespace inhabit::interact {
namespace {

constexpr size_t kWalks = 1;  // of the actions: idle, walk, sit

/// Networks of somebody who walks on the spot, `short_of` metres before their goal, whatever they see.
Networks walking_on_the_spot(double short_of) {
  Networks n = untrained_networks(small_interact_config());
  const OutputLayout out = output_layout(n.config);
  torch::Tensor mean = torch::zeros({out.size});
  auto values = mean.accessor<float, 1>();
  const int64_t keys = n.config.future_points();
  for (int64_t k = 0; k < keys; ++k) {
    const int64_t key = out.trajectory.first + k * (4 + n.config.actions), by_goal = out.goal_root.first + 4 * k;
    values[key + 3] = 1;  // straight ahead
    values[key + 4 + static_cast<int64_t>(kWalks)] = 1;
    values[by_goal + 1] = -static_cast<float>(short_of);
    values[by_goal + 3] = 1;
  }
  n.output_scale = {mean, torch::full({out.size}, 1e-6)};
  return n;
}

/// The frames until somebody who was told to walk `away` metres ahead is to walk no more; 200 where they still are.
int frames_until_arrived(double away) {
  const Engine engine(walking_on_the_spot(away), Predictor::pose);
  LivePerson person(engine, standing_clip({0, 0}, 0));
  person.plan_routes(false);
  person.walk_to({0, away}, 0);
  for (int t = 1; t < 200; ++t) {
    person.step();
    const Sample& now = person.state().now();
    EXPECT_LT(now.root.position.norm(), 0.05) << "they are to walk on the spot";
    EXPECT_GT(now.action[kWalks], 0.9F);
    if (person.state().samples.back().goal_action[kWalks] < 0.5F) return t;
  }
  return 200;
}

TEST(LivePerson, WhoStopsBesideTheirPlaceHasArrivedOnceTheyCouldSetOff) {
  EXPECT_EQ(frames_until_arrived(1.4), 200) << "too far to be there";
  for (const double away : {0.8, 0.4}) {
    const int frames = frames_until_arrived(away);
    EXPECT_GT(frames, 30) << away << " m: they have had no time to set off";
    EXPECT_LT(frames, 60) << away;
  }
  EXPECT_LT(frames_until_arrived(0.2), 5) << "they were there from the start";
}

// In the data somebody who walks without a goal is about to stop.
TEST(LivePerson, WhoWalksHasTheirFirstGoalAtOnceAndWhoStandsInASecond) {
  const Engine engine(walking_on_the_spot(2), Predictor::pose);
  const Clip walk = retarget(read_clip(INHABIT_SOURCE_DIR "/examples/data/walk.npz"), "walk");
  for (const bool walks : {true, false}) {
    LivePerson person(engine, walks ? walk : standing_clip({0, 0}, 0));
    person.plan_routes(false);
    person.walk_to({3, 3}, 0);
    EXPECT_EQ(person.state().samples.front().goal_action[kWalks], walks ? 1 : 0);
    EXPECT_EQ(person.state().samples[kSamples - 2].goal_action[kWalks], walks ? 1 : 0);
    EXPECT_EQ(person.state().samples.back().goal_action[kWalks], 1);
  }
}

TEST(StateAfter, KnowsTheSecondBeforeAndGoesOnAsThey) {
  const Clip walk = retarget(read_clip(INHABIT_SOURCE_DIR "/examples/data/walk.npz"), "walk");
  const int64_t last = walk.frames() - 1;
  const auto root = [&](int64_t t) {
    return Eigen::Vector2f(walk.joints[t][0][0].item<float>(), walk.joints[t][0][2].item<float>());
  };
  const State s = state_after(walk, "walk");
  EXPECT_GT(s.now().action[kWalks], 0.9F);
  for (const int64_t ago : {0, 10, 29})
    EXPECT_LT((s.samples[static_cast<size_t>(kNow - ago)].root.position - root(last - ago)).norm(), 1e-4F) << ago;
  const Eigen::Vector2f step = (root(last) - root(last - 5)) / 5;
  EXPECT_GT(30 * step.norm(), 0.5F) << "m/s: they walk";
  EXPECT_LT((s.samples[kNow + 20].root.position - root(last) - 20 * step).norm(), 1e-3F);
  EXPECT_GT(s.samples[kNow + 20].phase, s.now().phase);
  EXPECT_NEAR(s.velocity[0].x(), 30 * (root(last) - root(last - 1)).x(), 1e-3);
  EXPECT_EQ(s.samples.front().goal_action[kWalks], 0) << "they have no goal";

  const State still = state_after(frames_at(walk, std::vector<int64_t>(40, last)), "standing");
  EXPECT_LT((still.samples.back().root.position - root(last)).norm(), 1e-5F);
  EXPECT_LT(still.velocity[10].norm(), 1e-4F);
  EXPECT_EQ(still.now().action[0], 1);
}

}  // namespace
}  // namespace inhabit::interact
