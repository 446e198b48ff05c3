// Protects what partial keys give: it is met at the key, what the keys give beside it stays, and bones keep their
// lengths.
#include "inhabit/inbetween/reach.h"

#include <gtest/gtest.h>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/inbetween/keyframes.h"
#include "largest.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

constexpr int64_t kKey = 30;

/// Two seconds of standing still, arms down.
Clip standing() {
  Clip clip;
  clip.skeleton = builtin_body().skeleton;
  clip.rotations = torch::zeros({61, kStandardJoints, 3});
  clip.rotations.select(1, 16).select(1, 2).fill_(-1.2);
  clip.rotations.select(1, 17).select(1, 2).fill_(1.2);
  clip.trans = torch::tensor({0.F, 0.95F, 0.F}).expand({61, 3}).contiguous();
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

/// The clip with `joint` moved by `by` in the key.
Clip moved(const Clip& clip, int joint, const std::vector<float>& by) {
  Clip out = clip;
  out.joints = clip.joints.clone();
  out.joints[kKey][joint] += torch::tensor(by);
  return out;
}

void expect_posed(const Clip& clip) {
  EXPECT_LT(largest(joint_positions(clip.skeleton, clip.rotations, clip.trans) - clip.joints), 1e-4);
  EXPECT_LT(largest(clip.joints.diff(1, 0)) * 30, 4) << "m/s: no joint jumps";
}

double missed(const Clip& reached, const Clip& given, int joint) {
  return (reached.joints[kKey][joint] - given.joints[kKey][joint]).norm().item<double>();
}

TEST(ReachTargets, AHandGoesWhereTheArmReaches) {
  const Clip clip = standing(), given = moved(clip, 20, {-0.1F, 0.25F, 0.3F});
  const Clip reached = reach_targets(clip, given, {0, kKey, 60}, key_groups("pelvis,left_wrist"));
  EXPECT_LT(missed(reached, given, 20), 1e-3);
  EXPECT_TRUE(torch::equal(reached.rotations.select(1, 3), clip.rotations.select(1, 3))) << "no need to lean";
  EXPECT_TRUE(torch::equal(reached.joints[0], clip.joints[0]));
  EXPECT_TRUE(torch::equal(reached.joints[60], clip.joints[60]));
  expect_posed(reached);
}

TEST(ReachTargets, TheTrunkLeansForAHandOnAPelvisThatStays) {
  const Clip clip = standing(), given = moved(clip, 20, {0.F, 0.2F, 0.75F});
  const Clip reached = reach_targets(clip, given, {0, kKey, 60}, key_groups("pelvis,left_wrist"));
  EXPECT_LT(missed(reached, given, 20), 2e-3);
  EXPECT_LT(missed(reached, given, 0), 1e-4) << "the pelvis is where it was given";
  EXPECT_GT((reached.joints[kKey][15] - clip.joints[kKey][15])[2].item<double>(), 0.05) << "the head comes along";
  EXPECT_LT(largest(reached.joints[kKey].index_select(0, torch::tensor({7, 8, 10, 11})) -
                    clip.joints[kKey].index_select(0, torch::tensor({7, 8, 10, 11}))),
            1e-4);
  expect_posed(reached);
}

TEST(ReachTargets, ATrunkThatIsATargetDoesNotLean) {
  const Clip clip = standing(), given = moved(clip, 20, {0.F, 0.2F, 0.75F});
  const Clip reached = reach_targets(clip, given, {0, kKey, 60}, key_groups("pelvis,head,left_wrist"));
  EXPECT_LT(missed(reached, given, 15), 1e-4);
  EXPECT_GT(missed(reached, given, 20), 0.05);
}

TEST(ReachTargets, TheBodyComesAlongWhereTheRootIsFree) {
  const Clip clip = standing(), given = moved(clip, 20, {0.F, 0.F, 1.5F});
  const Clip reached = reach_targets(clip, given, {0, kKey, 60}, key_groups("left_wrist"));
  EXPECT_LT(missed(reached, given, 20), 2e-3);
  EXPECT_GT(reached.joints[kKey][0][2].item<double>(), 0.5);
  EXPECT_LT(largest(joint_positions(reached.skeleton, reached.rotations, reached.trans) - reached.joints), 1e-4);
}

}  // namespace
}  // namespace inhabit::inbetween
