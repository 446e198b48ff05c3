#include "inhabit/body/two_bone.h"

#include <gtest/gtest.h>

#include <random>

#include "inhabit/body/body_model.h"
#include "inhabit/math/quaternion.h"

namespace inhabit {
namespace {

using Eigen::Vector3d;

TEST(TwoBone, RightAngleHasTheClosedForm) {
  const TwoBone t = solve_two_bone({0, 1, 0}, 0.3, 0.4, {0, 0.5, 0}, {0, 0, 1});
  EXPECT_LT((t.end - Vector3d(0, 0.5, 0)).norm(), 1e-12);  // 3-4-5 triangle
  EXPECT_NEAR((t.mid - Vector3d(0, 1, 0)).dot(t.end - t.mid), 0.0, 1e-12);
  EXPECT_GT(t.mid.z(), 0.2);
}

TEST(TwoBone, ReachIsSoftAndMonotonous) {
  double last = 0;
  for (double d = 0.5; d < 1.5; d += 0.001) {
    const TwoBone t = solve_two_bone(Vector3d::Zero(), 0.45, 0.45, {0, -d, 0}, {0, 0, 1});
    EXPECT_NEAR(t.mid.norm(), 0.45, 1e-9);
    EXPECT_NEAR((t.end - t.mid).norm(), 0.45, 1e-9);
    EXPECT_GE(t.end.norm(), last);
    EXPECT_LT(t.end.norm(), 0.9 + 1e-12);
    EXPECT_LT(t.end.norm() - last, last == 0 ? 1.0 : 0.00101);
    if (d < 0.891) {
      EXPECT_NEAR(t.end.y(), -d, 1e-9);
    }
    last = t.end.norm();
  }
  // Too near for the bones, and no distance at all.
  EXPECT_NEAR(solve_two_bone(Vector3d::Zero(), 0.5, 0.3, {0, 0.05, 0}, {0, 0, 1}).end.norm(), 0.2, 1e-9);
  EXPECT_TRUE(solve_two_bone(Vector3d::Zero(), 0.5, 0.5, Vector3d::Zero(), {0, 1, 0}).mid.allFinite());
}

TEST(TwoBone, LimbRotationsBringTheJointsThere) {
  const Bones bones = bones_of(builtin_body().skeleton);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  for (const Limb& limb : {leg(Side::left), leg(Side::right), arm(Side::left), arm(Side::right)}) {
    const double reach = bones.offsets[limb.mid].norm() + bones.offsets[limb.end].norm();
    for (int trial = 0; trial < 100; ++trial) {
      const Vector3d start(u(random), u(random), u(random)), pole(u(random), u(random), u(random));
      const Vector3d target =
          start + Vector3d(u(random), u(random), u(random)).normalized() * reach * (0.5 + 0.4 * std::abs(u(random)));
      const Eigen::Quaterniond parent = quaternion_of({u(random), u(random), u(random)});
      const LimbPose pose = solve_limb(bones, limb, parent, start, target, pole);
      const Eigen::Quaterniond upper = parent * pose.start_rotation, lower = upper * pose.mid_rotation;
      const Vector3d mid = start + upper * bones.offsets[limb.mid], end = mid + lower * bones.offsets[limb.end];
      EXPECT_LT((mid - pose.joints.mid).norm(), 1e-9);
      EXPECT_LT((end - target).norm(), 1e-9);
      // The middle joint is a hinge about the axis normal to the rest limb and its pole.
      const Vector3d hinge = limb.rest_pole.cross(bones.offsets[limb.mid]).normalized();
      const Vector3d rotation = axis_angle_of(pose.mid_rotation);
      EXPECT_LT((rotation - rotation.dot(hinge) * hinge).norm(), 0.15);
      EXPECT_GT(rotation.dot(hinge), -0.1);
    }
  }
}

TEST(TwoBone, StandingLegIsTheRestPose) {
  const Skeleton& s = builtin_body().skeleton;
  const Bones bones = bones_of(s);
  const Limb limb = leg(Side::left);
  const Vector3d hip = bones.offsets[1];
  const LimbPose pose = solve_limb(bones, limb, Eigen::Quaterniond::Identity(), hip,
                                   hip + bones.offsets[4] + bones.offsets[7], {0, 0, 1}, 0.0);
  EXPECT_LT(axis_angle_of(pose.start_rotation).norm(), 0.02);
  EXPECT_LT(axis_angle_of(pose.mid_rotation).norm(), 0.02);
}

}  // namespace
}  // namespace inhabit
