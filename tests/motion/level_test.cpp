// Protects levelling: a known slope is found and taken away, of people who walk, turn, sit down and crouch, feet that
// are held up say nothing, and where nothing stands nothing is said.
#include "inhabit/motion/level.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/io/files.h"
#include "shared.h"

namespace inhabit {
namespace {

using Eigen::Vector3d;
using torch::Tensor;

/// The clip with its floor tilted by `degrees` about the level axis at `toward` radians from +X.
Clip tilted(Clip clip, double degrees, double toward) {
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(degrees * M_PI / 180, Vector3d(std::cos(toward), 0, std::sin(toward))).toRotationMatrix();
  Tensor matrix = torch::empty({3, 3});
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) matrix[r][c] = rotation(r, c);
  rotate_clip(clip, matrix);
  return clip;
}

/// How far off, in degrees, the slope of `clip` is found when it is tilted by 8 degrees in six directions: at worst,
/// seen from what is found of it untilted.
double worst_error(const Clip& clip) {
  double worst = 0;
  const FloorSlope as_is = floor_slope(clip);
  for (int k = 0; k < 6; ++k) {
    Clip sloping = tilted(clip, 8, k * M_PI / 3);
    const FloorSlope found = floor_slope(sloping);
    EXPECT_GT(found.degrees, 3) << k;
    level(sloping, found);
    Clip upright = clip;
    level(upright, as_is);
    // Up to a rotation about the vertical and a shift: heights, seen from the mean, are the same.
    const auto heights = [](const Clip& c) { return c.joints.select(2, 1) - c.joints.select(2, 1).mean(); };
    const double off = (heights(sloping) - heights(upright)).abs().max().item<double>();
    const Tensor spread = (clip.joints - clip.joints.flatten(0, 1).mean(0)).norm(2, 2).max();
    worst = std::max(worst, std::asin(std::min(1.0, off / spread.item<double>())) * 180 / M_PI);
  }
  return worst;
}

Clip example(const std::string& name) { return read_clip(INHABIT_SOURCE_DIR "/examples/data/" + name); }

/// Somebody of the built-in body who stands on one place after the other around a circle, and crouches at every other:
/// feet flat. @param held whether the left foot is held up half of the time, still
Clip around(int places, bool held) {
  const Skeleton& skeleton = builtin_body().skeleton;
  std::vector<Tensor> rotations, places_of;
  for (int k = 0; k < places; ++k) {
    const double yaw = 2 * M_PI * k / places, bend = k % 2 == 1 ? 1.2 : 0.1;
    Tensor pose = torch::zeros({22, 3});
    pose[0][1] = yaw;
    for (const int side : {0, 1}) {
      pose[1 + side][0] = -bend;
      pose[4 + side][0] = 2 * bend;
      pose[7 + side][0] = -bend;
    }
    if (held && k % 2 == 0) pose[4][0] = 1.5;  // a foot behind, half a metre up
    const Tensor at = torch::tensor({std::sin(yaw), 0.0, std::cos(yaw)}).to(torch::kFloat32);
    const Tensor joints = joint_positions(skeleton, pose.unsqueeze(0), at.unsqueeze(0));
    const Tensor low = joints[0].select(1, 1).min();
    const Tensor stand = at - torch::tensor({0.F, 1.F, 0.F}) * low;
    for (int t = 0; t < 30; ++t) {
      rotations.push_back(pose);
      places_of.push_back(stand);
    }
  }
  Clip clip;
  clip.skeleton = skeleton;
  clip.rate = 30;
  clip.rotations = torch::stack(rotations);
  clip.trans = torch::stack(places_of);
  clip.joints = joint_positions(skeleton, clip.rotations, clip.trans);
  return clip;
}

TEST(FloorSlope, IsFoundUnderFeetThatStandAllAround) {
  for (const bool held : {false, true}) {
    const Clip clip = around(12, held);
    EXPECT_LT(floor_slope(clip).degrees, 0.5) << held;
    EXPECT_FALSE(floor_slope(clip).certain());
    for (int k = 0; k < 6; ++k) {
      Clip sloping = tilted(clip, 9, k);
      const FloorSlope found = floor_slope(sloping);
      EXPECT_NEAR(found.degrees, 9, 0.5) << held << k;
      EXPECT_TRUE(found.certain());
      EXPECT_LT(found.off_plane, 0.01);
      EXPECT_GT(found.off_level, 0.05);
      level(sloping, found);
      EXPECT_LT(floor_slope(sloping).degrees, 0.2) << held << k;
    }
  }
}

TEST(FloorSlope, OfARecordedWalkAndOfOneWhoSitsDown) {
  EXPECT_LT(worst_error(example("walk.npz")), 1.5);
  EXPECT_LT(worst_error(example("sit.npz")), 2.5);
  const std::string folder = shared_folder();
  if (folder.empty()) GTEST_SKIP() << "no recordings beside the project";
  EXPECT_LT(worst_error(read_clip(folder + "/data/cmu/train/walking/walking_1.txt")), 1.5);
  EXPECT_LT(worst_error(read_clip(folder + "/data/cmu/train/basketball/basketball_1.txt")), 1.5);
}

TEST(FloorSlope, IsUnknownWhereNothingStands) {
  Clip clip = around(12, false);
  clip.joints = clip.joints + torch::arange(clip.frames()).view({-1, 1, 1}) * torch::tensor({0.1F, 0.F, 0.F});
  const FloorSlope found = floor_slope(slice(clip, 0, 5));
  EXPECT_LT(found.stances, FloorSlope::kLeastStances);
  EXPECT_FALSE(found.certain());
  EXPECT_EQ(found.degrees, 0);
}

TEST(FloorSlope, EverythingAnnotatedRotatesWithTheBody) {
  const Clip clip = around(8, false), moved = tilted(clip, 9, 1);
  EXPECT_LT((joint_positions(moved.skeleton, moved.rotations, moved.trans) - moved.joints).abs().max().item<double>(),
            1e-4);
}

}  // namespace
}  // namespace inhabit
