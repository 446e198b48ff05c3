#include "inhabit/motion/canonical.h"

#include <gtest/gtest.h>

#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/math/heading.h"
#include "inhabit/motion/pose_track.h"

using namespace inhabit;

namespace {

// Pelvis and two hips, facing `yaw` at (3, 1, -2) with a rest offset of the root, and all annotations.
Clip standing(double yaw, bool rotations = true) {
  Clip clip;
  clip.skeleton.names = {"pelvis", "left_hip", "right_hip"};
  clip.skeleton.parents = {-1, 0, 0};
  clip.skeleton.offsets = torch::tensor({{0.0F, -0.2F, 0.03F}, {0.1F, 0.0F, 0.0F}, {-0.1F, 0.0F, 0.0F}});
  clip.rotations = torch::zeros({2, 3, 3});
  clip.rotations.select(1, 0).select(1, 1) = yaw;
  clip.rotations[1][0] = torch::tensor({0.3F, -0.4F, 0.5F});
  clip.trans = torch::tensor({{3.0F, 1.2F, -2.03F}, {4.0F, 1.2F, -1.0F}});
  set_pose(clip, pose_track(clip));
  clip.hand_targets = torch::ones({2, 2, 4});
  clip.object_names = {"chair"};
  clip.object_pose = torch::ones({2, 1, 6});
  if (!rotations) clip.rotations = clip.trans = torch::Tensor();
  return clip;
}

}  // namespace

TEST(Canonical, TheRootComesToTheOriginAndFacesZ) {
  for (const double yaw : {0.0, 0.7, M_PI / 2, 3.0, -2.5})
    for (const bool rotations : {true, false}) {
      const Clip clip = standing(yaw, rotations);
      EXPECT_NEAR(heading(clip, 0), yaw, 1e-5);
      const Clip out = transformed(clip, canonical_transform(clip));
      EXPECT_NEAR(heading(out, 0), 0, 1e-5);
      const torch::Tensor root = out.joints[0][0];
      EXPECT_NEAR(root[0].item<double>(), 0, 1e-5);
      EXPECT_NEAR(root[1].item<double>(), 1.0, 1e-5);
      EXPECT_NEAR(root[2].item<double>(), 0, 1e-5);
      EXPECT_GT(out.joints[0][1][0].item<double>(), 0.099);  // left hip to the left, +X
      if (rotations) {
        EXPECT_TRUE(torch::allclose(joint_positions(out.skeleton, out.rotations, out.trans), out.joints, 0, 1e-5));
      }
    }
}

TEST(Canonical, WhatBelongsToThePersonMovesAlong) {
  const Clip clip = standing(0.7);
  const GroundTransform by = canonical_transform(clip, 1);
  const Clip out = transformed(clip, by);
  const auto distance = [](const Clip& c) {
    return (c.hand_targets[0][1].slice(0, 0, 3) - c.joints[1][2]).norm().item<double>() +
           (c.object_pose[1][0].slice(0, 0, 3) - c.joints[0][1]).norm().item<double>();
  };
  EXPECT_NEAR(distance(out), distance(clip), 1e-5);
  EXPECT_EQ(out.hand_targets[0][0][3].item<float>(), 1);
  EXPECT_NEAR(heading(out, 1), 0, 1e-5);
  const Clip back = transformed(out, by.inverse());
  for (const auto& [a, b] : {std::pair{back.joints, clip.joints},
                             {back.trans, clip.trans},
                             {back.rotations, clip.rotations},
                             {back.object_pose, clip.object_pose}})
    EXPECT_TRUE(torch::allclose(a, b, 0, 1e-5));
}

TEST(Canonical, HipsAndShouldersTellTheHeadingOfTensorsAsOfVectors) {
  using Eigen::Vector3f;
  // Hips face +Z and shoulders, twice as wide, 90 degrees to the left (+X): the line between both.
  const std::array<Vector3f, 4> at = {Vector3f(0.1F, 1, 0), Vector3f(-0.1F, 1, 0), Vector3f(0, 1.4F, -0.2F),
                                      Vector3f(0, 1.5F, 0.2F)};
  const Vector3f left = right_to_left(at[0], at[1], at[2], at[3]);
  EXPECT_LT((left - Vector3f(0.2F, -0.1F, -0.4F)).norm(), 1e-6F);
  EXPECT_NEAR(heading_of_left(left.x(), left.z()), std::atan2(0.4, 0.2), 1e-6);
  torch::Tensor joints = torch::zeros({1, 22, 3});
  const std::array<int64_t, 4> rows = {1, 2, 16, 17};
  for (size_t i = 0; i < 4; ++i) std::copy_n(at[i].data(), 3, joints[0][rows[i]].data_ptr<float>());
  EXPECT_NEAR(headings(joints)[0].item<double>(), std::atan2(0.4, 0.2), 1e-6);
}

TEST(Canonical, OtherSkeletonsFaceAsTheirRoot) {
  Clip clip = standing(0.7);
  clip.skeleton.names = {"a", "b", "c"};
  EXPECT_NEAR(heading(clip, 0), 0.7, 1e-5);
  clip.rotations = torch::Tensor();
  EXPECT_THROW(heading(clip, 0), Error);
  EXPECT_THROW(canonical_transform(clip, 2), Error);
  EXPECT_THROW(canonical_transform(clip, -1), Error);
}
