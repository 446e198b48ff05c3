// Protects what in-betweening sees of a scene: what stands in front of somebody is in front whichever way they face,
// offsets end on the scene, and windows of data sets are canonical and agree with the scene as it is.
#include "inhabit/inbetween/sample.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "forecast/walker_data.h"
#include "inhabit/body/body_model.h"
#include "inhabit/inbetween/config.h"
#include "inhabit/inbetween/features.h"
#include "inhabit/math/rotation.h"
#include "inhabit/motion/placed_body.h"
#include "inhabit/scene/shapes.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit::inbetween {
namespace {

using ::testing::HasSubstr;
using torch::Tensor;

/// A wall 1.2 m wide and 0.2 m thick, its near side 1 m ahead of somebody at `root` who faces `yaw`, from the floor to
/// 1.6 m; `aside` metres to their left.
Scene wall_ahead(const Tensor& root, double yaw, double aside) {
  Scene scene;
  MeshBuilder wall;
  wall.box({0, 0.8, 1.1}, {0.6, 0.8, 0.1});
  Mesh box = wall.mesh("wall", {0.5F, 0.5F, 0.5F});
  box.vertices.select(1, 0).add_(aside);
  box.vertices = box.vertices.matmul(yaw_matrix(yaw).t()) + root * torch::tensor({1.F, 0.F, 1.F});
  scene.meshes.push_back(box);
  return scene;
}

TEST(SceneOccupancy, AWallInFrontStaysInFrontUnderAnyRotationOfTheRoot) {
  const Tensor root = torch::tensor({0.7F, 0.95F, -2.3F});
  Tensor first;
  for (const double yaw : {0., 0.9, 2.2, -1.4, 3.1}) {
    const Tensor grid = scene_occupancy(SceneQuery(wall_ahead(root, yaw, 0)), root, yaw, 48);
    ASSERT_EQ(grid.sizes(), (torch::IntArrayRef{24, 48, 48}));
    EXPECT_EQ(grid[12][24][24 + 10].item<float>(), 1) << "chest height, straight ahead, in the wall's first 10 cm";
    EXPECT_EQ(grid[12][24][24 - 10].item<float>(), -1) << "behind";
    EXPECT_EQ(grid[12][24 + 10][24].item<float>(), -1) << "to the left";
    EXPECT_EQ(grid[22][24][24 + 10].item<float>(), -1) << "over the wall";
    if (!first.defined()) first = grid;
    EXPECT_GT((grid == first).to(torch::kFloat32).mean().item<double>(), 0.99) << yaw;
  }
  const Tensor left = scene_occupancy(SceneQuery(wall_ahead(root, 0.9, 1.5)), root, 0.9, 48);
  EXPECT_EQ(left[12][24 + 15][24 + 10].item<float>(), 1);
  EXPECT_EQ(left[12][24 - 15][24 + 10].item<float>(), -1);
}

TEST(AnchorPositions, LieOnTheSkinWhereTheClipStands) {
  const Clip clip = walker(3, 1, 0.5, 1, 2, 3);
  const Tensor anchors = anchor_positions(clip, 64);
  Clip shaped = clip;
  shaped.betas = body_betas(clip);
  EXPECT_TRUE(anchors.equal(anchor_points(shaped, builtin_body()))) << "64 are those that the body comes with";
  ASSERT_EQ(anchors.sizes(), (torch::IntArrayRef{3, 64, 3}));
  const Tensor nearest = torch::cdist(anchors, clip.joints).amin(2);
  EXPECT_LT(nearest.max().item<double>(), 0.35);
  EXPECT_LT(anchors[0].select(1, 1).min().item<double>(), 0.1) << "some are on the feet";
  EXPECT_GT(anchors[0].select(1, 1).max().item<double>(), 1.5) << "and on the head";
  const Tensor more = anchor_positions(clip, 256);
  ASSERT_EQ(more.sizes(), (torch::IntArrayRef{3, 256, 3}));
  EXPECT_LT((more.slice(1, 0, 64) - anchors).abs().max().item<double>(), 1e-5) << "furthest points go on";
}

Config short_windows() {
  Config config = preset("features");
  config.frames = 31;
  config.padded = 32;
  return config;
}

TEST(Data, HasEveryWholeWindowOfClipsThatHaveAScene) {
  const TempFolder folder;
  const std::string path = write_walkers(folder / "data");
  EXPECT_EQ(Data({path}, "train", short_windows(), 30).size(), 3);  // starts 0, 30, 60 of 120 frames
  EXPECT_EQ(Data({path}, "all", short_windows(), 30).size(), 9);
  Config slow = short_windows();
  slow.rate = 25;
  EXPECT_THAT(refusal_of([&] { Data({path}, "all", slow, 30); }), HasSubstr("frames a second"));
}

TEST(Data, WindowsAreCanonicalAndSeeTheirScene) {
  const TempFolder folder;
  const Data data({write_walkers(folder / "data", 30, 1)}, "all", short_windows(), 30);
  for (int64_t i = 0; i < data.size(); ++i) {
    const Sample s = data.sample(i);
    ASSERT_EQ(s.features.sizes(), (torch::IntArrayRef{31, kFeatureCount}));
    EXPECT_TRUE(torch::equal(s.features, data.features(i)));
    EXPECT_LT(s.features[0].slice(0, 0, 3).index({torch::tensor({0, 2})}).abs().max().item<double>(), 1e-5);
    EXPECT_NEAR(s.features[30][2].item<double>(), 1.2, 0.02) << "goes ahead for a second";
    // The floor is all there is: every offset points straight down, as far as its anchor is high.
    EXPECT_LT(s.offsets.select(2, 0).abs().max().item<double>(), 2e-3);
    EXPECT_LT(s.offsets.select(2, 2).abs().max().item<double>(), 2e-3);
    const Window window = data.window(i);
    EXPECT_LT((s.offsets.select(2, 1) + anchor_positions(window.truth, 64).select(2, 1)).abs().max().item<double>(),
              2e-3);
    const double root = window.truth.joints[0][0][1].item<double>();
    const auto floor_cell = static_cast<int64_t>(std::floor((1.2 - root) / 0.1));
    EXPECT_EQ(s.occupancy[floor_cell].min().item<float>(), 1) << "the floor's own layer is full";
    EXPECT_EQ(s.occupancy.slice(0, floor_cell + 2).max().item<float>(), -1) << "and nothing is over it";
    EXPECT_TRUE(torch::equal(s.occupancy, data.sample(i).occupancy)) << "kept as it was found";
  }
}

}  // namespace
}  // namespace inhabit::inbetween
