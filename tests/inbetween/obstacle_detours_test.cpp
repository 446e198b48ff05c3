// Protects the detours: bent where the straight path is blocked and there alone, clear of what blocks it, whole
// bodies moved with their root, constrained features left.
#include "inhabit/inbetween/obstacle_detours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "inbetween/table_detour.h"
#include "inbetween/whole_keys.h"
#include "inhabit/inbetween/features.h"
#include "inhabit/inbetween/keyframes.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

struct BlockedWalk {
  Detour detour = table_detour(121, 30);
  Tensor root = detour.ends.root_path() - detour.ends.root_path()[0] * torch::tensor({1.F, 0.F, 1.F});
  Tensor floor = scene_floor(SceneQuery(detour.room), detour.ends.joints[0][0], 0);
};

TEST(ObstacleDetours, BendWhereTheTableStands) {
  const BlockedWalk w;
  const Tensor detours = detours_around(w.floor, w.root, whole_keys(121, {0, 120}));
  EXPECT_TRUE(crosses_table(w.detour.ends));
  EXPECT_FALSE(crosses_table(walked_along(w.detour.ends, detours)));
  EXPECT_EQ(detours[0].abs().max().item<float>(), 0);
  EXPECT_EQ(detours[120].abs().max().item<float>(), 0);
  EXPECT_LT(detours.diff(1, 0).norm(2, {1}).max().item<double>(), 0.05) << "no jump";
}

TEST(ObstacleDetours, AreStraightWhereNothingStandsOrTheRootIsNotTold) {
  const BlockedWalk w;
  const Tensor free = torch::full({96, 96}, -1.F);
  EXPECT_EQ(detours_around(free, w.root, whole_keys(121, {0, 120})).abs().max().item<float>(), 0);
  Tensor groups = whole_keys(121, {0, 60, 120});
  groups[60].zero_();
  groups[60][kJointGroups + 20] = 1;  // a wrist
  EXPECT_EQ(detours_around(w.floor, w.root, groups).abs().max().item<float>(), 0);
  EXPECT_EQ(detours_around(w.floor, w.root, whole_keys(121, {0, 20, 30})).abs().max().item<float>(), 0)
      << "before the table";
  EXPECT_EQ(detours_around(w.floor, w.root * 3, whole_keys(121, {0, 120})).abs().max().item<float>(), 0)
      << "ends beyond the floor";
  const Tensor wall = torch::full({96, 96}, -1.F);
  wall.slice(1, 58, 60).fill_(1);
  std::vector<int64_t> unreached;
  EXPECT_EQ(detours_around(wall, w.root, whole_keys(121, {0, 120}), &unreached).abs().max().item<float>(), 0)
      << "no path at all";
  EXPECT_EQ(unreached, std::vector<int64_t>{120});
}

TEST(ObstacleDetours, AreFoundFromDistancesAsFromTheSceneItself) {
  const BlockedWalk w;
  Clip ends = w.detour.ends;  // beside the table's middle, so that one side is shorter
  ends.trans = ends.trans + torch::tensor({0.2F, 0.F, 0.F});
  ends.joints = ends.joints + torch::tensor({0.2F, 0.F, 0.F});
  const Poses poses = poses_of(ends);
  const SceneDistances distances(w.detour.room);
  const Tensor groups = whole_keys(121, {0, 120}), found = detours_of_poses(poses, groups, distances),
               of_scene = detours_of_clip(ends, groups, SceneQuery(w.detour.room), 0);
  EXPECT_GT(found.abs().max().item<double>(), 0.3);
  EXPECT_LT((found - of_scene).abs().max().item<double>(), 0.15);
  const Tensor mirror = detours_of_poses(window_of(poses, 0, 121, true), groups, distances.mirrored());
  EXPECT_LT((mirror - found * torch::tensor({-1.F, 1.F})).abs().max().item<double>(), 0.15);
}

/// Metres from the path of somebody who goes 3 m ahead, beyond 0.6 m from its ends, to the nearest occupied square.
double room_beside(const Tensor& floor, const Tensor& root, const Tensor& detours) {
  double least = 10;
  for (int64_t t = 0; t < root.size(0); ++t) {
    const double x = root[t][0].item<double>() + detours[t][0].item<double>(),
                 z = root[t][2].item<double>() + detours[t][1].item<double>();
    if (z < 0.6 || z > 2.4) continue;
    for (int64_t i = 0; i < 96; ++i)
      for (int64_t k = 0; k < 96; ++k)
        if (floor[i][k].item<float>() > 0)
          least = std::min(
              least,
              std::hypot(0.1 * (static_cast<double>(i) - 47.5) - x, 0.1 * (static_cast<double>(k) - 47.5) - z) - 0.05);
  }
  return least;
}

TEST(ObstacleDetours, LeaveRoomForArmsWhereThatIsHardlyLonger) {
  Tensor root = torch::zeros({61, 3});
  root.select(1, 2).copy_(torch::linspace(0, 3, 61));
  const Tensor groups = whole_keys(61, {0, 60});
  Tensor post = torch::full({96, 96}, -1.F);
  post.slice(0, 47, 49).slice(1, 62, 64).fill_(1);  // in the middle of the line
  EXPECT_GT(room_beside(post, root, detours_around(post, root, groups)), 0.42);
  // A wall with a door of 0.8 m, which ends 2.5 m to the right: who goes through is nearer than that to it.
  Tensor wall = torch::full({96, 96}, -1.F);
  wall.slice(0, 20, 51).slice(1, 62, 64).fill_(1);
  wall.slice(0, 59, 84).slice(1, 62, 64).fill_(1);
  const Tensor through = detours_around(wall, root, groups);
  EXPECT_LT(through.select(1, 0).max().item<double>(), 1.2) << "not around the wall's end";
  EXPECT_GT(through.select(1, 0).max().item<double>(), 0.5);
  EXPECT_GT(room_beside(wall, root, through), 0.27);
}

TEST(ObstacleDetours, TurnWithThePerson) {
  const BlockedWalk w;
  Tensor left = torch::full({96, 96}, -1.F);
  left.slice(0, 52, 56).slice(1, 40, 56).fill_(1);  // 0.4 to 0.8 m to the left
  Tensor root = torch::zeros({41, 3});
  root.select(1, 0).copy_(torch::linspace(0, 1.6, 41));  // goes left
  const Tensor groups = whole_keys(41, {0, 40});
  const Tensor detours = detours_around(left, root, groups);
  EXPECT_GT(detours.select(1, 1).abs().max().item<double>(), 0.8) << "ahead or back around it";
}

TEST(AlongDetours, MovesRootAndJointsButNothingGiven) {
  const Tensor deviation = torch::full({kFeatureCount}, 0.5), between = torch::zeros({1, kFeatureCount, 3});
  Tensor detours = torch::zeros({1, 3, 2}), mask = torch::zeros({1, kFeatureCount, 3});
  detours[0][1] = torch::tensor({0.1F, -0.2F});
  mask[0][kJointFeature + 3] = 1;  // x of the second joint
  const Tensor moved = along_detours(between, detours, mask, deviation)[0];
  EXPECT_FLOAT_EQ(moved[0][1].item<float>(), 0.2F);
  EXPECT_FLOAT_EQ(moved[2][1].item<float>(), -0.4F);
  EXPECT_EQ(moved[1].abs().max().item<float>(), 0) << "heights stay";
  EXPECT_EQ(moved.slice(0, 3, kJointFeature).abs().max().item<float>(), 0) << "and rotations";
  EXPECT_EQ(moved[kJointFeature + 3][1].item<float>(), 0) << "given";
  EXPECT_FLOAT_EQ(moved[kJointFeature + 63][1].item<float>(), 0.2F);
  EXPECT_FLOAT_EQ(moved[kJointFeature + 65][1].item<float>(), -0.4F);
  EXPECT_EQ(moved.select(1, 0).abs().max().item<float>(), 0);
}

TEST(ObstacleDetours, TheBodyTurnsWithItsPath) {
  // A metre ahead in 100 frames, and as far aside and back again.
  std::vector<Eigen::Vector2d> straight;
  Tensor detours = torch::zeros({101, 2});
  for (int64_t t = 0; t <= 100; ++t) {
    straight.emplace_back(0, 0.01 * static_cast<double>(t));
    detours[t][0] = 0.01 * static_cast<double>(std::min(t, 100 - t));
  }
  const std::vector<double> turns = yaws_along(straight, detours, {0, 100});
  EXPECT_EQ(turns[0], 0);
  EXPECT_EQ(turns[100], 0);
  EXPECT_NEAR(turns[30], M_PI / 4, 1e-6) << "+Z turns towards +X";
  EXPECT_NEAR(turns[50], 0, 1e-6);
  EXPECT_NEAR(turns[70], -M_PI / 4, 1e-6);
  EXPECT_GT(turns[8], 0.05);
  EXPECT_LT(turns[8], M_PI / 4) << "near a key part of it";
  const std::vector<double> none = yaws_along(straight, torch::zeros({101, 2}), {0, 100});
  EXPECT_EQ(*std::max_element(none.begin(), none.end()), 0);
}

}  // namespace
}  // namespace inhabit::inbetween
