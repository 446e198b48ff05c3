// Protects how a scene's meshes are grouped into objects, and which of them feet stand on.
#include "inhabit/scene/objects.h"

#include <gtest/gtest.h>

#include "inhabit/scene/query.h"
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
  EXPECT_TRUE(is_floor("Floor"));
  EXPECT_TRUE(is_floor("Ground.001"));
}

TEST(Objects, AreNamedOnceInTheOrderOfTheirMeshes) {
  Scene scene;
  for (const char* name : {"wall_0", "floor", "chair_0", "wall_0.1", "chair_0.1", "rug.3"}) {
    scene.meshes.push_back(box_mesh({0, 0, 0}, {1, 1, 1}));
    scene.meshes.back().name = name;
  }
  EXPECT_EQ(object_names(scene), (std::vector<std::string>{"wall_0", "chair_0"}));
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

/// A cube around people is a room, whichever way its faces look; a wardrobe beside them is none.
TEST(Objects, ARoomThatPeopleAreInLooksIn) {
  Scene scene = scene_of({box_mesh({0, 1.5, 0}, {6, 3, 6}), box_mesh({2, 1, 2}, {1.6, 1.9, 1.6})});
  const torch::Tensor people = torch::tensor({{0.F, 1.F, 0.F}, {0.5F, 1.F, 0.F}, {2.F, 1.F, 2.F}});
  EXPECT_TRUE(SceneQuery(scene).inside(people).all().item<bool>());
  const Scene turned = rooms_looking_in(scene, people);
  const torch::Tensor inside = SceneQuery(turned).inside(people);
  EXPECT_FALSE(inside[0].item<bool>());
  EXPECT_FALSE(inside[1].item<bool>());
  EXPECT_TRUE(inside[2].item<bool>()) << "a wardrobe is solid for who goes through it now and then";
  EXPECT_TRUE(torch::equal(rooms_looking_in(turned, people).meshes[0].faces, turned.meshes[0].faces));
  const Rooms rooms(scene);
  for (int again = 0; again < 2; ++again) {
    EXPECT_EQ(rooms.turned_for(people), std::vector<size_t>{0});
    EXPECT_EQ(rooms.turned_for(people.slice(0, 2)), (std::vector<size_t>{0, 1}));
    EXPECT_TRUE(rooms.turned_for(people + 20).empty());
  }
}

TEST(Objects, TheGroundOfAScanIsWhatLooksUpFromTheFloor) {
  Scene scan;
  scan.meshes.push_back(box_mesh({0, 0, 0}, {1, 1, 1}));
  Mesh& mesh = scan.meshes.front();
  const int64_t faces = mesh.faces.size(0);
  // A sheet that looks up, from which the box rises.
  mesh.vertices = torch::cat({mesh.vertices, torch::tensor({{3.F, 0.01F, 0.F}, {3.F, 0.02F, 2.F}, {5.F, 0.F, 0.F}})});
  const int64_t first = mesh.vertices.size(0) - 3;
  mesh.faces = torch::cat({mesh.faces, torch::tensor({{first, first + 1, first + 2}}).to(mesh.faces.scalar_type())});
  scan.points = torch::tensor({{0.F, 0.01F, 0.F}, {0.F, 0.5F, 0.F}});
  const Scene rest = without_ground(scan);
  EXPECT_EQ(rest.meshes.front().faces.size(0), faces);
  ASSERT_EQ(rest.points.size(0), 1);
  EXPECT_EQ(rest.points[0][1].item<float>(), 0.5F);
  EXPECT_EQ(without_ground(scan, -1).meshes.front().faces.size(0), faces + 1) << "a metre over the floor";
}

}  // namespace
}  // namespace inhabit
