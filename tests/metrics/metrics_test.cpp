#include <gtest/gtest.h>

#include <cmath>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/metrics/dynamics.h"
#include "inhabit/metrics/foot_skating.h"
#include "inhabit/metrics/penetration.h"
#include "inhabit/scene/shapes.h"
#include "metrics/standing.h"

namespace inhabit {
namespace {

Clip shifted(Clip clip, const torch::Tensor& by) {  // by (T, 3)
  clip.trans = clip.trans + by;
  clip.joints = clip.joints + by.unsqueeze(1);
  return clip;
}

TEST(FootSkating, CountsFramesInWhichALowFootMoves) {
  Clip clip = standing(5);
  EXPECT_EQ(foot_skating(clip).frames, 4);
  EXPECT_EQ(foot_skating(clip).skating, 0);
  clip.joints.select(0, 2).select(0, 10).select(0, 0).add_(0.03);  // away and back: two of four moves
  EXPECT_EQ(foot_skating(clip).skating, 2);
  EXPECT_DOUBLE_EQ(foot_skating(clip).fraction(), 0.5);
  clip.joints.select(0, 2).select(0, 10).select(0, 0).sub_(0.01);  // 2 cm only
  EXPECT_EQ(foot_skating(clip).skating, 0);
  clip = standing(5);
  clip.joints.select(0, 2).select(0, 10).add_(0.3);  // from low to high: the move away counts, the one back does not
  EXPECT_EQ(foot_skating(clip).skating, 1);
  EXPECT_EQ(foot_skating(slice(clip, 0, 1)).frames, 0);
}

TEST(Dynamics, OfAPathOfConstantJerkIsThatOfItsFormula) {
  const double rate = 30, jerk = 6, start = 1.2;
  const torch::Tensor t = torch::arange(40, torch::kDouble) / rate;
  torch::Tensor by = torch::zeros({40, 3}, torch::kDouble);
  by.select(1, 0).copy_(start * t + jerk / 6 * t * t * t);
  Clip clip = standing(40);
  clip.joints = clip.joints.to(torch::kDouble) + by.unsqueeze(1);
  const Dynamics d = dynamics(clip);
  EXPECT_EQ(d.frames, 37);
  EXPECT_NEAR(d.jerk, jerk, 1e-6);
  EXPECT_NEAR(d.acceleration, jerk * 19 / rate, 1e-6);  // mean over frames 0..36 of jerk (t + 1/rate)
  const double mean_t2 = [&] {
    double sum = 0;
    for (int i = 0; i < 37; ++i) sum += (std::pow((i + 1) / rate, 3) - std::pow(i / rate, 3)) * rate / 37;
    return sum;
  }();
  EXPECT_NEAR(d.speed, start + jerk / 6 * mean_t2, 1e-6);
}

TEST(Dynamics, LooksAtTheFramesOfAnActionOnly) {
  Clip clip = standing(40);
  torch::Tensor by = torch::zeros({40, 3});
  by.select(1, 2).slice(0, 20).copy_(torch::arange(20) * 0.04F);  // still, then 1.2 m/s
  clip = shifted(clip, by);
  clip.action_names = {"stand", "walk"};
  clip.action = torch::zeros({40}, torch::kInt64);
  clip.action.slice(0, 20).fill_(1);
  const Dynamics walk = dynamics(clip, frames_of_action(clip, "walk"));
  EXPECT_EQ(walk.frames, 17);
  EXPECT_NEAR(walk.speed, 1.2, 1e-4);
  EXPECT_NEAR(dynamics(clip, frames_of_action(clip, "stand")).speed, 0, 1e-6);
  EXPECT_EQ(dynamics(clip, frames_of_action(clip, "swim")).frames, 0);
}

TEST(Penetration, IsTheDepthOfTheCapsulesInWhatIsNotSatOn) {
  Clip clip = standing(6);
  Scene scene;
  scene.meshes.push_back(block("floor", {0, -0.05, 0}, {3, 0.05, 3}));
  EXPECT_EQ(deepest_penetration(clip, builtin_body(), scene).depth, 0);  // the floor does not count
  // A wall, its face beside the body; then 5 cm nearer.
  const double reach = [&] {
    Scene far;
    far.meshes.push_back(block("wall_0", {2.05, 1, 0}, {0.05, 1, 2}));
    // From the wall's face at x = 2 back to the outermost capsule.
    double widest = 0;
    const Pose pose = forward_kinematics(clip.skeleton.parents, clip.skeleton.offsets,
                                         torch::eye(3).expand({kStandardJoints, 3, 3}), clip.trans[0]);
    for (const Capsule& c : builtin_body().capsules)
      widest = std::max<double>(widest, pose.positions[c.joint][0].item<float>() + std::max(c.a[0], c.b[0]) + c.radius);
    return widest;
  }();
  scene.meshes.push_back(block("wall_0", {reach + 0.01 + 0.5, 1, 0}, {0.5, 1, 2}));
  EXPECT_EQ(deepest_penetration(clip, builtin_body(), scene).depth, 0);
  torch::Tensor by = torch::zeros({6, 3});
  by[4][0] = 0.06;
  const Penetration p = deepest_penetration(shifted(clip, by), builtin_body(), scene);
  EXPECT_NEAR(p.depth, 0.05, 2e-3);
  EXPECT_EQ(p.frame, 4);
  EXPECT_EQ(p.object, "wall_0");
}

TEST(Penetration, LeavesOutWhatIsSatOnWhileItIs) {
  Clip clip = standing(6);
  Scene scene;
  scene.meshes.push_back(block("stool_0", {0, 0.5, 0}, {0.2, 0.5, 0.2}));
  EXPECT_GT(deepest_penetration(clip, builtin_body(), scene).depth, 0.1);
  clip.contact = torch::zeros({6, kStandardJoints});
  clip.contact.select(1, 0).fill_(1);
  EXPECT_EQ(supporting_objects(clip, scene), std::vector<std::string>(6, "stool_0"));
  EXPECT_EQ(deepest_penetration(clip, builtin_body(), scene).depth, 0);
  clip.contact[5][0] = 0;
  EXPECT_EQ(deepest_penetration(clip, builtin_body(), scene).frame, 5);
  clip.action_names = {"stand_up"};
  clip.action = torch::zeros({6}, torch::kInt64);
  EXPECT_EQ(deepest_penetration(clip, builtin_body(), scene).depth, 0);
}

TEST(Limits, ExcessIsThatOfTheWorstJoint) {
  Clip clip = standing(4);
  EXPECT_EQ(beyond_limits(clip, builtin_body()).radians, 0);
  const double highest = builtin_body().joint_limits[4][0][1].item<double>();
  clip.rotations[2][4][0] = highest + 0.25;
  const LimitExcess excess = beyond_limits(clip, builtin_body());
  EXPECT_NEAR(excess.radians, 0.25, 1e-5);
  EXPECT_EQ(excess.frame, 2);
  EXPECT_EQ(excess.joint, 4);
}

TEST(HandContact, MeasuresPointAndSkinAgainstTheSurface) {
  Clip clip = standing(3);
  const BodyModel& body = builtin_body();
  const torch::Tensor vertices = skin(body, {}, torch::eye(3).expand({kStandardJoints, 3, 3}), clip.trans[0]);
  const torch::Tensor hand = vertices.index({body.skin_weights.select(1, 20).gt(0.5)});
  const float low = hand.select(1, 1).min().item<float>();  // a block 4 mm below the left hand
  const torch::Tensor middle = hand.mean(0);
  Scene scene;
  scene.meshes.push_back(
      block("table_0", {middle[0].item<float>(), low - 0.004 - 0.1, middle[2].item<float>()}, {0.3, 0.1, 0.3}));
  clip.hand_targets = torch::zeros({3, 2, 4});
  EXPECT_EQ(hand_contact(clip, body, scene).contacts, 0);
  clip.hand_targets[1][0] =
      torch::tensor({middle[0].item<float>(), low - 0.004F + 0.007F, middle[2].item<float>(), 1.F});
  const HandContact got = hand_contact(clip, body, scene);
  EXPECT_EQ(got.contacts, 1);
  EXPECT_NEAR(got.target_gap, 0.007, 1e-4);
  EXPECT_NEAR(got.hand_gap, 0.004, 5e-4);
}

}  // namespace
}  // namespace inhabit
