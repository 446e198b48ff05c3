// Protects the box around what a scene holds, and what it is from above.
#include "inhabit/scene/bounding_box.h"

#include <gtest/gtest.h>

namespace inhabit {
namespace {

TEST(BoundingBox, IsAroundMeshesAndPoints) {
  EXPECT_TRUE(bounding_box({}).isEmpty());
  EXPECT_TRUE(on_ground(bounding_box({})).isEmpty());
  Scene scene = floor_scene(2, 1, 0);
  scene.meshes.emplace_back();
  scene.meshes.back().vertices = torch::zeros({0, 3});
  scene.points = torch::tensor({0.5F, 2.F, -4.F}).view({1, 3});
  const Eigen::AlignedBox3d box = bounding_box(scene);
  EXPECT_EQ(box.min(), Eigen::Vector3d(0, 0, -4));
  EXPECT_EQ(box.max(), Eigen::Vector3d(2, 2, 1));
  EXPECT_EQ(on_ground(box).min(), Eigen::Vector2d(0, -4));
  EXPECT_EQ(on_ground(box).max(), Eigen::Vector2d(2, 1));
}

}  // namespace
}  // namespace inhabit
