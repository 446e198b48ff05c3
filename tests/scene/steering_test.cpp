// Protects steered motion: around what stands in the way, in the same steps, and not changed where nothing does.
#include "inhabit/scene/steering.h"

#include <gtest/gtest.h>

#include "forecast/walker.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/shapes.h"
#include "largest.h"

namespace inhabit {
namespace {

using torch::Tensor;

/// Someone who walks 10 m along +Z from the origin.
Clip walk() { return walker(241, 1.25, 0, 1, 2); }

Scene with_box(double x, double z, double half) {
  Scene scene = floor_scene();
  MeshBuilder box;
  box.box({x, 0.5, z}, {half, 0.5, half});
  scene.meshes.push_back(box.mesh("box", {0.5F, 0.5F, 0.5F}));
  return scene;
}

Clip among(const Scene& scene) { return steered(walk(), free_space(obstacles_of(scene))); }

/// Metres from the root's path to the middle of a box.
double nearest_to(const Clip& clip, double x, double z) {
  const Tensor root = clip.root_path();
  return torch::hypot(root.select(1, 0) - x, root.select(1, 2) - z).min().item<double>();
}

TEST(Steering, GoesAroundWhatStandsInTheWay) {
  const Tensor start = walk().root_path()[0], ahead = walk().root_path()[240] - start;
  ASSERT_GT(ahead[2].item<double>(), 8) << "the walker walks along +Z";
  const double x = start[0].item<double>() + 0.1, z = start[2].item<double>() + 4;
  EXPECT_LT(nearest_to(walk(), x, z), 0.15);
  const Clip around = among(with_box(x, z, 0.4));
  EXPECT_GT(nearest_to(around, x, z), 0.4 + 0.2);
  EXPECT_GT(around.root_path()[240][2].item<double>(), z + 2) << "past it";
  EXPECT_TRUE(torch::equal(around.joints[0], walk().joints[0]));
}

TEST(Steering, KeepsStepsAndPoses) {
  const Tensor start = walk().root_path()[0];
  const Clip before = walk(), around = among(with_box(start[0].item<double>() + 0.1, start[2].item<double>() + 4, 0.4));
  const auto steps = [](const Clip& c) { return c.root_path().diff(1, 0).norm(2, {1}); };
  EXPECT_LT(largest_difference(steps(around), steps(before)), 1e-4);
  EXPECT_LT(largest_difference(around.root_path().select(1, 1), before.root_path().select(1, 1)), 1e-5);
  const auto bones = [](const Clip& c) { return (c.joints.select(1, 15) - c.joints.select(1, 0)).norm(2, {1}); };
  EXPECT_LT(largest_difference(bones(around), bones(before)), 1e-4);
  ASSERT_TRUE(before.rotations.defined());
  EXPECT_TRUE(torch::equal(around.rotations.slice(1, 1), before.rotations.slice(1, 1))) << "the root alone rotates";
}

TEST(Steering, ChangesNothingWhereNothingIsNear) {
  const Tensor start = walk().root_path()[0];
  EXPECT_TRUE(torch::equal(among(with_box(start[0].item<double>() + 3, start[2].item<double>() + 4, 0.4)).joints,
                           walk().joints));
  EXPECT_TRUE(torch::equal(among(floor_scene()).joints, walk().joints)) << "and beyond the grid all is free";
}

TEST(Steering, TurnsBackFromAWall) {
  Scene scene = floor_scene();
  const Tensor start = walk().root_path()[0];
  MeshBuilder wall;
  wall.box({start[0].item<double>(), 1.2, start[2].item<double>() + 3}, {15, 1.2, 0.1});
  scene.meshes.push_back(wall.mesh("wall", {0.5F, 0.5F, 0.5F}));
  const Clip back = among(scene);
  EXPECT_LT(back.root_path().select(1, 2).max().item<double>(), start[2].item<double>() + 3 - 0.15);
}

/// A wall across +Z, so many metres ahead of where the walk starts.
Scene with_wall(double ahead) {
  Scene scene = floor_scene();
  const Tensor start = walk().root_path()[0];
  MeshBuilder wall;
  wall.box({start[0].item<double>(), 1.2, start[2].item<double>() + ahead}, {4, 1.2, 0.02});
  scene.meshes.push_back(wall.mesh("wall", {0.5F, 0.5F, 0.5F}));
  return scene;
}

TEST(Steering, NobodyGoesThroughAThinWallAlthoughBehindItAllIsClear) {
  const double z = walk().root_path()[0][2].item<double>();
  for (const double ahead : {0.8, 1.2, 2.0})
    EXPECT_LT(among(with_wall(ahead)).root_path().select(1, 2).max().item<double>(), z + ahead) << ahead;
}

TEST(Steering, WhoStartsNearSomethingGoesNoNearerAndThroughNothing) {
  const Tensor start = walk().root_path()[0];
  const double x = start[0].item<double>(), z = start[2].item<double>();
  Scene scene = with_wall(1.5);
  MeshBuilder box;  // the root starts 0.2 m beside it
  box.box({x + 0.5, 0.5, z}, {0.3, 0.5, 0.3});
  scene.meshes.push_back(box.mesh("box", {0.5F, 0.5F, 0.5F}));
  const Clip around = among(scene);
  EXPECT_LT(around.root_path().select(1, 2).max().item<double>(), z + 1.5);
  EXPECT_GT(nearest_to(around, x + 0.5, z), 0.3 + 0.1);
}

}  // namespace
}  // namespace inhabit
