// Protects A* over the floor: the shortest path where its length is known, clear of what stands there, none where there
// is none.
#include "inhabit/scene/walk_path.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace inhabit {
namespace {

using Eigen::Vector2d;

/// An empty floor of 8 x 8 m around the origin with a wall of no width: points (x, 0), `from` <= x <= `to`.
FreeSpace floor_with_wall(double from, double to) {
  FreeSpace out;
  out.nx = out.nz = 161;
  out.origin = {-4, -4};
  for (int k = 0; k < out.nz; ++k)
    for (int i = 0; i < out.nx; ++i) {
      const Vector2d p = out.point(i, k);
      const double far =
          from > to ? FreeSpace::kFarthest : (p - Vector2d(std::clamp(p.x(), from, to), 0)).norm();  // none: from > to
      const double edge = 4.2 - p.cwiseAbs().maxCoeff();
      out.clearance.push_back(static_cast<float>(std::min({far, edge, FreeSpace::kFarthest})));
    }
  return out;
}

TEST(WalkPath, IsStraightOnAFreeFloor) {
  const FreeSpace floor = floor_with_wall(1, 0);
  for (const Vector2d& to : {Vector2d(2, 0), Vector2d(0, 2), Vector2d(2, 2)}) {
    const auto path = find_path(floor, -to / 2, to / 2, 0.3);
    ASSERT_TRUE(path.has_value());
    EXPECT_NEAR(path->total(), to.norm(), 0.03);
    EXPECT_LT((path->at(0) + to / 2).norm(), 1e-9);
    EXPECT_LT((path->at(path->total()) - to / 2).norm(), 0.021) << "points are 2 cm apart";
    EXPECT_NEAR(path->heading(path->total() / 2), heading_of(to), 0.05);
  }
}

TEST(WalkPath, GoesAroundAWallByTheShorterEnd) {
  const double margin = 0.4;
  const FreeSpace floor = floor_with_wall(-2, 0.5);  // from far left to half a metre right
  const Vector2d from(-0.5, -1.5), to(-0.5, 1.5);
  const auto path = find_path(floor, from, to, margin);
  ASSERT_TRUE(path.has_value());
  double nearest = 1e9, most_right = -1e9;
  for (const Vector2d& p : path->points) {
    nearest = std::min(nearest, (p - Vector2d(std::clamp(p.x(), -2.0, 0.5), 0)).norm());
    most_right = std::max(most_right, p.x());
  }
  EXPECT_GT(nearest, margin - 0.08) << "the margin, less a step of the grid";
  EXPECT_GT(most_right, 0.5 + margin - 0.08) << "around the near end";
  // Two tangents to a circle around the wall's end and the arc between them: nothing is shorter at that distance.
  const auto shortest = [&](double apart) {
    const double reach = (from - Vector2d(0.5, 0)).norm(), at_end = 2 * std::atan2(1.5, 1.0);
    return 2 * std::sqrt(reach * reach - apart * apart) + apart * (2 * M_PI - at_end - 2 * std::acos(apart / reach));
  };
  EXPECT_GT(path->total(), shortest(margin - 0.08));
  EXPECT_LT(path->total(), 1.15 * shortest(margin)) << "people keep farther off than they must, but not far";
}

TEST(WalkPath, ThereIsNoneThroughAWallFromSideToSide) {
  const FreeSpace floor = floor_with_wall(-5, 5);
  EXPECT_FALSE(find_path(floor, {0, -1.5}, {0, 1.5}, 0.3).has_value());
  EXPECT_TRUE(find_path(floor, {-1, -1.5}, {1, -1.5}, 0.3).has_value());
}

TEST(WalkPath, HasMoreRoomWhereThatIsHardlyLonger) {
  const FreeSpace floor = floor_with_wall(-2, 0.5);
  const Vector2d from(-0.5, -1.5), to(-0.5, 1.5);
  const auto length = [&](const LongerPath& longer) {
    const auto path = find_roomy_path(floor, from, to, {0.9, 0.6, 0.2}, longer);
    return path ? path->total() : 0;
  };
  const auto alone = [&](double margin) { return find_path(floor, from, to, margin)->total(); };
  ASSERT_GT(alone(0.6), 1.02 * alone(0.2));
  ASSERT_GT(alone(0.9), 1.1 * alone(0.6));
  EXPECT_EQ(length({}), alone(0.2)) << "no longer than the shortest";
  EXPECT_EQ(length({.times = 1.001 * alone(0.6) / alone(0.2)}), alone(0.6));
  EXPECT_EQ(length({.times = 1, .more = 1.001 * alone(0.9) - alone(0.2)}), alone(0.9));
  EXPECT_EQ(length({.times = 10, .longest = 1.001 * alone(0.6)}), alone(0.6)) << "not the widest";
  EXPECT_EQ(length({.times = 10, .longest = 0.9 * alone(0.2)}), 0) << "none is so short";
  EXPECT_FALSE(find_roomy_path(floor_with_wall(-5, 5), from, to, {0.4, 0.2}, {.times = 10}).has_value());
}

TEST(WalkPath, PointsLieEvenlyAndLengthsAddUp) {
  const auto path = find_path(floor_with_wall(-2, 0.5), {-0.5, -1.5}, {-0.5, 1.5}, 0.4);
  ASSERT_TRUE(path.has_value());
  ASSERT_EQ(path->points.size(), path->length.size());
  for (size_t i = 1; i < path->points.size(); ++i) {
    const double step = (path->points[i] - path->points[i - 1]).norm();
    EXPECT_LT(step, 0.021);
    EXPECT_NEAR(path->length[i] - path->length[i - 1], step, 1e-9);
  }
}

TEST(Heading, GoesFromZToX) {
  EXPECT_NEAR(heading_of({0, 1}), 0, 1e-12);
  EXPECT_NEAR(heading_of({1, 0}), M_PI / 2, 1e-12);
  for (double a = -3; a < 3; a += 0.5) {
    EXPECT_NEAR(heading_of(ahead_of(a)), a, 1e-12);
    EXPECT_NEAR(heading_of(left_of(a)), wrapped(a + M_PI / 2), 1e-12) << "left of +Z is +X";
    EXPECT_NEAR(wrapped(a + 4 * M_PI), a, 1e-12);
  }
}

}  // namespace
}  // namespace inhabit
