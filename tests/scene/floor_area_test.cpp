// Protects where people are kept who live in a room: on its floor, over the holes of a scan, and anywhere where the
// scene has no floor under them.
#include "inhabit/scene/floor_area.h"

#include <gtest/gtest.h>

#include "forecast/walker.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/shapes.h"
#include "inhabit/scene/steering.h"

namespace inhabit {
namespace {

/// A floor from (-2, -2) to (2, 2) as two strips with a gap between them, and a post in its corner.
Scene two_strips(double gap) {
  Scene scene;
  for (const double side : {-1.0, 1.0}) {
    MeshBuilder strip;
    const double width = (4 - gap) / 4;
    strip.box({0, -0.02, side * (2 - width)}, {2, 0.02, width});
    scene.meshes.push_back(strip.mesh("floor", {0.5F, 0.5F, 0.5F}));
  }
  MeshBuilder post;
  post.box({-1.8, 0.5, -1.8}, {0.1, 0.5, 0.1});
  scene.meshes.push_back(post.mesh("post", {0.5F, 0.5F, 0.5F}));
  return scene;
}

FreeSpace space_of(const Scene& scene, const Eigen::Vector2d& place) {
  return free_floor(scene, obstacles_of(scene), place);
}

TEST(FloorArea, EndsWhereTheFloorDoes) {
  const FreeSpace space = space_of(two_strips(0), {0, 0});
  for (const auto& [x, clear] : {std::pair(0.0, 1.0), {1.4, 0.6}, {1.8, 0.2}, {2.3, -0.3}})
    EXPECT_NEAR(space.at({x, 0.4}), clear, 0.06) << x;
  EXPECT_NEAR(space.at({-1.5, -1.8}), 0.2, 0.02) << "of the post, which is as near as the edge";
}

TEST(FloorArea, GapsUnderAMetreAreHolesOfAScan) {
  EXPECT_NEAR(space_of(two_strips(0.8), {0, 1.5}).at({0, 0}), 1, 0.06);
  const FreeSpace apart = space_of(two_strips(1.6), {0, 1.5});
  EXPECT_LT(apart.at({0, 0}), -0.2);
  EXPECT_GT(apart.at({0, 1.4}), 0.3);
}

TEST(FloorArea, PointsOfAScanAreFloorToo) {
  Scene scene = two_strips(0);
  const torch::Tensor steps = torch::arange(-2, 2, 0.1);
  const std::vector<torch::Tensor> grid = torch::meshgrid({steps, steps}, "ij");
  scene.points = torch::stack({grid[0].flatten() + 4, torch::zeros(grid[0].numel()), grid[1].flatten()}, 1);
  EXPECT_GT(space_of(scene, {0, 0}).at({2.5, 0.4}), 0.5) << "it goes on";
}

TEST(FloorArea, WhoStandsBesideTheFloorMayGoAnywhere) {
  const Scene scene = two_strips(0);
  EXPECT_NEAR(space_of(scene, {2.6, 0}).at({2.6, 0}), 1, 1e-6);
  EXPECT_NEAR(space_of(scene, {2.6, 0}).at({-1.5, -1.8}), 0.2, 0.02) << "of the post";
}

TEST(FloorArea, SteeredPeopleStayOnIt) {
  Scene scene = two_strips(0);
  const Clip walk = walker(241, 1.25, 0, 1, 0);  // 10 m along +Z
  const torch::Tensor start = walk.root_path()[0];
  const Clip kept = steered(walk, space_of(scene, {start[0].item<double>(), start[2].item<double>()}));
  EXPECT_GT(walk.root_path().select(1, 2).max().item<double>(), 8);
  const torch::Tensor farthest = std::get<0>(kept.root_path().abs().max(0));
  for (const int axis : {0, 2}) EXPECT_LT(farthest[axis].item<double>(), 2.0) << farthest;
}

}  // namespace
}  // namespace inhabit
