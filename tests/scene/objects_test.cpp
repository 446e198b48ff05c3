// Protects how a scene's meshes are grouped into objects, and which of them feet stand on.
#include "inhabit/scene/objects.h"

#include <gtest/gtest.h>

#include "scene/shapes.h"

namespace inhabit {
namespace {

TEST(Objects, GoByTheNamesOfTheirMeshes) {
  EXPECT_EQ(object_of_mesh("chair_0.2"), "chair_0");
  EXPECT_EQ(object_of_mesh("chair_0"), "chair_0");
  EXPECT_EQ(object_of_mesh("a.b"), "a.b");
  EXPECT_EQ(object_of_mesh("kitchen_chair_030.012"), "kitchen_chair_030.012") << "a copy, not a part";
  EXPECT_TRUE(is_floor("floor.001"));
  EXPECT_EQ(object_of_mesh("chair."), "chair.");
  EXPECT_TRUE(is_floor("floor"));
  EXPECT_TRUE(is_floor("rug.1"));
  EXPECT_FALSE(is_floor("floor_lamp"));
}

TEST(Objects, ObstaclesAreWhatIsLeft) {
  Scene scene;
  for (const char* name : {"floor", "rug.3", "chair_0", "chair_0.1", "wall_0"}) {
    scene.meshes.push_back(box_mesh({0, 0, 0}, {1, 1, 1}));
    scene.meshes.back().name = name;
  }
  EXPECT_EQ(obstacles_of(scene).meshes.size(), 3U);
  const Scene rest = obstacles_of(scene, "chair_0");
  ASSERT_EQ(rest.meshes.size(), 1U);
  EXPECT_EQ(rest.meshes[0].name, "wall_0");
}

}  // namespace
}  // namespace inhabit
