// Protects the height that feet stand on: the scene's where it has something below them, the poses' own elsewhere.
#include "inhabit/scene/floor.h"

#include <gtest/gtest.h>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "largest.h"
#include "scene/shapes.h"

namespace inhabit {
namespace {

/// The built-in body at rest, standing on the height `y`.
Clip standing(double y, int64_t frames = 40) {
  const BodyModel& body = builtin_body();
  Clip clip;
  clip.skeleton = body.skeleton;
  clip.rotations = torch::zeros({frames, 22, 3});
  clip.trans = torch::zeros({frames, 3});
  clip.trans.select(1, 1).fill_(y - body.template_vertices.select(1, 1).min().item<double>());
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

TEST(FloorUnder, IsTheScenesWhereItIsNear) {
  Mesh floor = floor_scene(6).meshes[0];
  for (const double off : {0.0, 0.04, -0.08}) {
    const SceneQuery scene(scene_of({floor}));
    EXPECT_NEAR(floor_under(standing(off), scene), 0, 1e-5) << "feet " << off << " m off the floor";
  }
  // On a platform, though the floor goes on below it; beside it, the floor.
  const SceneQuery platform(scene_of({floor, box_mesh({0, 0.25, 0}, {2, 0.5, 2})}));
  EXPECT_NEAR(floor_under(standing(0.5), platform), 0.5, 1e-5);
  Clip beside = standing(0);
  beside.joints.select(2, 0).add_(2);
  EXPECT_NEAR(floor_under(beside, platform), 0, 1e-5);
  // Under a table.
  const SceneQuery table(scene_of({floor, box_mesh({0, 0.72, 0}, {2, 0.04, 2})}));
  EXPECT_NEAR(floor_under(standing(0), table), 0, 1e-5);
}

TEST(FloorUnder, IsTheCloudsWhereThereAreNoFaces) {
  Scene cloud;
  torch::manual_seed(1);
  cloud.points = torch::cat({(torch::rand({4000, 3}) - 0.5) * torch::tensor({3.F, 0.01F, 3.F}),
                             torch::tensor({0.F, 1.5F, 0.F}) + 0.1F * torch::rand({100, 3})});
  EXPECT_NEAR(floor_under(standing(0.03), SceneQuery(cloud)), 0, 0.005);
}

TEST(FloorUnder, IsThePosesWhereTheSceneHasNothingBelow) {
  const SceneQuery far(scene_of({box_mesh({9, 0, 9}, {1, 1, 1})}));
  for (const double y : {0.0, 1.0, -0.4}) {
    EXPECT_NEAR(floor_under(standing(y), far), y, 0.02);
    EXPECT_NEAR(floor_under(standing(y, 3), far), y, 0.02) << "a few key poses";
  }
}

TEST(AssumedFloor, LiesUnderTheFeetWhereThePersonIs) {
  Clip clip = standing(0.3);
  clip.joints = clip.joints + torch::tensor({7.F, 0.F, -3.F});
  const torch::Tensor vertices = assumed_floor(clip).meshes[0].vertices;
  EXPECT_LT(largest(vertices.select(1, 1) - 0.3), 0.02);
  EXPECT_NEAR(vertices.select(1, 0).mean().item<float>(), 7, 0.1);
  // A skeleton of other joints: the lowest.
  clip.skeleton = {{"a", "b"}, {-1, 0}, torch::zeros({2, 3})};
  clip.joints = torch::tensor({0.F, 1.F, 0.F, 0.F, 0.52F, 0.F}).view({1, 2, 3});
  EXPECT_NEAR(assumed_floor(clip).meshes[0].vertices[0][1].item<float>(), 0.5, 1e-5);
}

}  // namespace
}  // namespace inhabit
