// Protects the free floor around meshes: exact distances to what stands on it, and what is stepped over or walked
// under.
#include "inhabit/scene/free_space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "inhabit/error.h"
#include "inhabit/math/random.h"
#include "inhabit/scene/shapes.h"

namespace inhabit {
namespace {

using Eigen::Vector2d;

Scene box_scene(const Eigen::Vector3d& center, const Eigen::Vector3d& half) {
  MeshBuilder builder;
  builder.box(center, half);
  Scene scene;
  scene.name = "box";
  scene.meshes.push_back(builder.mesh("box_0", {0.5F, 0.5F, 0.5F}));
  return scene;
}

TEST(FreeSpaceOfMeshes, IsTheDistanceToABox) {
  const Vector2d half(0.63, 0.32);
  const FreeSpace space = free_space(box_scene({0.4, 0.5, -0.2}, {half.x(), 0.5, half.y()}), 1.5);
  double widest = 0;
  for (int k = 0; k < space.nz; ++k)
    for (int i = 0; i < space.nx; ++i) {
      const Vector2d p = space.point(i, k) - Vector2d(0.4, -0.2);
      const double far = std::min((p.cwiseAbs() - half).cwiseMax(0).norm(), FreeSpace::kFarthest);
      EXPECT_NEAR(space.clearance[static_cast<size_t>(k) * static_cast<size_t>(space.nx) + static_cast<size_t>(i)], far,
                  5e-3);
      widest = std::max(widest, p.cwiseAbs().maxCoeff());
    }
  EXPECT_NEAR(widest, 0.63 + 1.5, 0.06);
}

TEST(FreeSpaceOfMeshes, ThresholdsAreSteppedOverAndLampsWalkedUnder) {
  for (const double height : {0.02, 2.2}) {
    const FreeSpace space = free_space(box_scene({0, height, 0}, {0.5, 0.02, 0.5}));
    EXPECT_EQ(*std::min_element(space.clearance.begin(), space.clearance.end()),
              static_cast<float>(FreeSpace::kFarthest));
  }
  EXPECT_LT(free_space(box_scene({0, 1.5, 0}, {0.5, 0.02, 0.5})).at({0, 0}), 1e-6) << "a table top";
  // A wall that begins below the floor and ends above the ceiling, of no width.
  Scene wall;
  Mesh mesh;
  mesh.name = "wall_0";
  mesh.vertices = torch::tensor({{-1.F, -1.F, 0.F}, {1.F, -1.F, 0.F}, {1.F, 3.F, 0.F}, {-1.F, 3.F, 0.F}});
  mesh.faces = torch::tensor({{0, 1, 2}, {0, 2, 3}}, torch::kInt64);
  wall.meshes = {mesh};
  const FreeSpace space = free_space(wall);
  EXPECT_NEAR(space.at({0, 0.4}), 0.4, 5e-3);
  EXPECT_NEAR(space.at({1.3, 0}), 0.3, 5e-3) << "not along the line that it goes on in";
}

TEST(FreeSpaceOfMeshes, OfNothingIsFreeAndOfTooMuchRefused) {
  EXPECT_NEAR(free_space(Scene{}).at({1, 1}), FreeSpace::kFarthest, 1e-6);
  EXPECT_THROW(free_space(box_scene({0, 1, 0}, {150, 1, 1})), Error);
}

}  // namespace
}  // namespace inhabit
