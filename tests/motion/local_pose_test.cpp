// Protects what anticipation looks at: poses that know neither place nor heading, the root motion that carries them,
// bones of another length, and mirror images.
#include "inhabit/motion/local_pose.h"

#include <gtest/gtest.h>

#include "forecast/walker.h"
#include "inhabit/anticipate/features.h"
#include "inhabit/math/rotation.h"
#include "largest.h"

namespace inhabit {
namespace {

using torch::Tensor;

/// A walker who turns as well, by 3 degrees a frame, all the way round.
Tensor turning_walker(int64_t frames = 130) {
  Clip clip = walker(frames, 1.2, 0, 1);
  clip.rotations.select(1, 0).select(1, 1).copy_(torch::arange(frames) * (M_PI / 60));
  return joint_positions(clip.skeleton, clip.rotations, clip.trans);
}

TEST(LocalPoses, KnowNeitherPlaceNorHeading) {
  const Tensor joints = turning_walker(), poses = local_poses(joints);
  EXPECT_LT(largest(poses.select(1, 0)), 1e-6) << "the root is the origin";
  EXPECT_LT(largest(headings(poses)), 1e-4);
  for (const double yaw : {0.4, 2.0, -3.0}) {
    const Tensor moved = torch::matmul(joints, yaw_matrix(yaw).t()) + torch::tensor({5.F, 0.F, -8.F});
    EXPECT_LT(largest(local_poses(moved) - poses), 1e-4) << yaw;
    const Tensor turned = headings(moved) - headings(joints) - yaw;
    EXPECT_LT(largest(torch::atan2(turned.sin(), turned.cos())), 1e-4) << yaw;
    EXPECT_LT(largest(root_motion(moved) - root_motion(joints)), 1e-4) << yaw;
  }
  EXPECT_GT(largest(local_poses(joints + torch::tensor({0.F, 1.F, 0.F})) - joints), 0.1);
}

TEST(Headings, AreZeroAlongZAnd90DegreesAlongX) {
  const Tensor ahead = walker(2, 0).joints;
  EXPECT_LT(largest(headings(ahead)), 1e-3);
  EXPECT_NEAR(headings(walker(2, 0, M_PI / 2).joints)[0].item<double>(), M_PI / 2, 1e-3);
}

TEST(RootMotion, IsTheStepSeenFromTheFrameBeforeTheTurnAndTheHeight) {
  // Walks at 1.2 m/s, 30 frames a second, 4 cm a frame, whichever way it goes.
  for (const double yaw : {0.0, 1.0, -2.5}) {
    const Tensor motion = root_motion(walker(10, 1.2, yaw).joints);
    EXPECT_EQ(motion[0].slice(0, 0, 3).abs().sum().item<double>(), 0) << "no step to the first frame";
    EXPECT_LT(largest(motion.slice(0, 1).select(1, 0)), 1e-4);
    EXPECT_LT(largest(motion.slice(0, 1).select(1, 1) - 0.04), 1e-4);
    EXPECT_LT(largest(motion.select(1, 2)), 1e-4);
  }
  const Tensor turning = root_motion(turning_walker());
  EXPECT_LT(largest(turning.slice(0, 1).select(1, 2) - M_PI / 60), 1e-3) << "also past 180 degrees";
  const Tensor joints = walker(3, 0).joints;
  EXPECT_LT(largest(root_motion(joints).select(1, 3) - joints.select(1, 0).select(1, 1)), 1e-6);
}

TEST(PlacedPoses, BringTheMotionBack) {
  const Tensor joints = turning_walker();
  const Tensor back = placed_poses(local_poses(joints), root_motion(joints), joints[0][0], headings(joints)[0]);
  EXPECT_LT(largest(back - joints), 1e-3);
  // From the middle on, after the frame before.
  const Tensor later = placed_poses(local_poses(joints).slice(0, 50), root_motion(joints).slice(0, 50), joints[49][0],
                                    headings(joints)[49]);
  EXPECT_LT(largest(later - joints.slice(0, 50)), 1e-3);
  const Tensor both = torch::stack({joints, joints + 1});  // with a leading dimension
  EXPECT_LT(largest(placed_poses(local_poses(both), root_motion(both), both.select(1, 0).select(1, 0),
                                 headings(both).select(1, 0)) -
                    both),
            1e-3);
}

TEST(OnSkeleton, KeepsAnglesAndScalesThePathWithTheLegs) {
  const Clip clip = walker(20, 1.2, 0.5, 1);
  Skeleton tall = clip.skeleton;
  tall.offsets = tall.offsets.clone();
  for (const int64_t j : {4, 5, 7, 8}) tall.offsets[j] *= 1.25;  // legs
  for (const int64_t j : {18, 19}) tall.offsets[j] *= 2;         // arms change no root motion
  const Clip out = on_skeleton(clip, tall);
  EXPECT_TRUE(torch::equal(out.rotations, clip.rotations));
  EXPECT_LT(largest(out.root_path() - clip.root_path() * 1.25), 1e-5);
  EXPECT_LT(largest(out.joints - joint_positions(tall, out.rotations, out.trans)), 1e-6);
  EXPECT_LT(largest(on_skeleton(out, clip.skeleton).joints - clip.joints), 1e-4) << "and back";
}

TEST(MirroredFeatures, TwiceAreTheSame) {
  const Tensor features = anticipate::joint_features(turning_walker(20));
  EXPECT_EQ(features.size(1), 67);
  EXPECT_LT(largest(anticipate::mirrored_features(anticipate::mirrored_features(features)) - features), 1e-7);
}

TEST(MirroredFeatures, AreThoseOfThePersonSeenInAMirror) {
  // The mirror stands in the yz plane: x changes its sign and left is right.
  Tensor joints = turning_walker(30);
  joints = joints + 0.02 * torch::sin(torch::arange(22)).view({1, 22, 1});  // nobody is symmetric
  const std::vector<int64_t> other = {0, 2, 1, 3, 5, 4, 6, 8, 7, 9, 11, 10, 12, 14, 13, 15, 17, 16, 19, 18, 21, 20};
  const Tensor seen = joints.index_select(1, torch::tensor(other)) * torch::tensor({-1.F, 1.F, 1.F});
  const Tensor features = anticipate::joint_features(joints), expected = anticipate::joint_features(seen);
  EXPECT_LT(largest(anticipate::mirrored_features(features) - expected), 1e-4);
  EXPECT_GT(largest(features - expected), 0.05);
}

TEST(FeatureJoints, AreTheMotionAgain) {
  const Tensor joints = turning_walker(40), features = anticipate::joint_features(joints);
  EXPECT_LT(largest(anticipate::feature_poses(features) - local_poses(joints)), 1e-6);
  EXPECT_LT(largest(anticipate::feature_joints(features, joints[0][0], headings(joints)[0]) - joints), 1e-3);
}

TEST(FeatureScale, StandardisesAndFloorsWhatHardlyMoves) {
  torch::manual_seed(2);
  Tensor features = torch::randn({500, 67}) * 2 + 3;
  features.select(1, 7) = 1;
  features.select(1, 66) = 1;
  const FeatureScale scale = anticipate::feature_scale(features);
  const Tensor x = scale.to_network(features);
  EXPECT_LT(largest(x.mean(0)), 1e-4);
  EXPECT_NEAR(x.select(1, 3).std(/*unbiased=*/false).item<double>(), 1, 1e-5);
  EXPECT_NEAR(scale.deviation[7].item<double>(), 0.05, 1e-6);
  EXPECT_NEAR(scale.deviation[66].item<double>(), 1e-3, 1e-6);
  EXPECT_LT(largest(scale.from_network(x) - features), 1e-4);
}

}  // namespace
}  // namespace inhabit
