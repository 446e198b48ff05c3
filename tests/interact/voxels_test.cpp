// Protects the chair's grid and the ego-centric grid: sizes, values, and that they go with the person.
#include "inhabit/interact/voxels.h"

#include <gtest/gtest.h>

#include "inhabit/interact/layout.h"
#include "inhabit/math/heading.h"
#include "inhabit/scene/query.h"
#include "inhabit/scene/shapes.h"
#include "interact/chair_scene.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

Place place(double x, double z, double heading) {
  return {Vector2f(static_cast<float>(x), static_cast<float>(z)), ahead_of(heading).cast<float>()};
}

Scene box_scene(const Eigen::Vector3d& center, const Eigen::Vector3d& half) {
  MeshBuilder builder;
  builder.box(center, half);
  Scene scene = floor_scene();
  scene.meshes.push_back(builder.mesh("wall_0", {1, 1, 1}));
  return scene;
}

TEST(Voxels, APlacesAxesAreAheadAndLeft) {
  const Place p = place(1, 2, 0.6);
  const Eigen::Vector2d left = left_of(0.6), ahead = ahead_of(0.6);
  const Vector3f world(static_cast<float>(1 + 2 * left.x() + 3 * ahead.x()), 0.5F,
                       static_cast<float>(2 + 2 * left.y() + 3 * ahead.y()));
  EXPECT_LT((p.in(world)-Vector3f(2, 0.5F, 3)).norm(), 1e-5F);
  EXPECT_LT((p.out({2, 0.5F, 3}) - world).norm(), 1e-5F);
}

TEST(Voxels, TheGridsHaveThePapersSizes) {
  const Config config = preset("paper");
  EXPECT_EQ(EgoGrid(config).points().size(), 1408U);
  Config release = config;
  release.ego_rings = release.ego_layers = 9;
  EXPECT_EQ(EgoGrid(release).points().size(), 2034U);
  const InputLayout in = input_layout(config);
  EXPECT_EQ(in.size, 4344);
  EXPECT_EQ(in.goals.first, 355);
  EXPECT_EQ(in.ego.first, 472);
  EXPECT_EQ(in.chair.size, 2048);
  EXPECT_EQ(in.gating.first, 4032);
  EXPECT_EQ(output_layout(config).size, 536);
}

TEST(Voxels, AWallOnTheLeftStaysOnTheLeftUnderAnyHeadingAndPlace) {
  const EgoGrid ego(preset("paper"));
  for (const double heading : {0.0, 1.1, M_PI, -2.3}) {
    const double x = 3 * heading, z = -heading;
    const Eigen::Vector2d at = Eigen::Vector2d(x, z) + 1.0 * left_of(heading);
    MeshBuilder builder;
    builder.box({0, 1, 0}, {0.1, 1, 1.5});
    Mesh wall = builder.mesh("wall_0", {1, 1, 1});
    const Place stands = place(at.x(), at.y(), heading);
    float* v = wall.vertices.data_ptr<float>();
    for (int64_t i = 0; i < wall.vertices.size(0); ++i, v += 3)
      Eigen::Map<Vector3f>(v, 3) = stands.out(Eigen::Map<Vector3f>(v, 3));
    Scene scene = floor_scene();
    scene.meshes.push_back(wall);
    const Surroundings around(scene, 0.02);
    std::vector<float> out(ego.points().size());
    ego.sense(around, place(x, z, heading), out.data());
    double left = 0, right = 0;
    for (size_t i = 0; i < out.size(); ++i) {
      const Vector3f& p = ego.points()[i];
      (p.x() > 0 ? left : right) += static_cast<double>(out[i]);
      const Vector3f apart = (Vector3f(p.x() - 1, p.y() - 1, p.z()).cwiseAbs() - Vector3f(0.1F, 1, 1.5F)).cwiseMax(0.F);
      EXPECT_NEAR(out[i], std::max(0.F, 1 - apart.norm() / ego.radius()), 0.08) << i << " " << heading;
    }
    EXPECT_GT(left, 20);
    EXPECT_NEAR(right, 0, 1e-4) << heading;
  }
}

TEST(Voxels, FarFromEverythingTheEgoGridIsEmptyAndInsideASolidItIsFull) {
  const EgoGrid ego(preset("paper"));
  const Surroundings around(box_scene({0, 1, 0}, {5, 2.5, 5}));
  std::vector<float> out(ego.points().size(), -1);
  ego.sense(around, place(20, 0, 1), out.data());
  EXPECT_EQ(*std::max_element(out.begin(), out.end()), 0);
  ego.sense(around, place(0, 0, 1), out.data());
  EXPECT_EQ(*std::min_element(out.begin(), out.end()), 1);
  ego.sense(Surroundings(floor_scene()), place(0, 0, 1), out.data());
  EXPECT_EQ(*std::max_element(out.begin(), out.end()), 0);
}

TEST(Voxels, TheChairsGridIsSolidWhereTheChairIs) {
  const Config config = preset("paper");
  // A box of 0.8 x 0.4 x 0.8 m under one of half its width: an L seen from the side.
  MeshBuilder builder;
  builder.box({0, 0.2, 0}, {0.4, 0.2, 0.4});
  builder.box({0, 0.6, -0.2}, {0.4, 0.2, 0.2});
  Chair chair{"chair_0", builder.mesh("chair_0", {1, 1, 1}), Eigen::Isometry3d::Identity(), 0.4};
  const ChairGrid grid = sense_chair(chair, config);
  ASSERT_EQ(grid.centres.size(), 512U);
  for (size_t i = 0; i < 512; ++i) {
    const size_t y = i / 64, z = i % 8;
    EXPECT_FLOAT_EQ(grid.values[i], y < 4 || z < 4 ? 1 : 0) << i;
    EXPECT_NEAR(grid.centres[i].y(), -0.0 + 0.05 + 0.1 * static_cast<double>(y), 2e-3);
  }
  EXPECT_LT((grid.centres[8] - Vector3f(-0.25F, 0.05F, -0.35F)).norm(), 3e-3F);  // y outermost, then x, then z
}

TEST(Voxels, ThinBoardsCountByTheirDistanceWithinTheCell) {
  const Config config = preset("paper");
  MeshBuilder builder;
  builder.box({0, 0.425, 0}, {0.4, 0.005, 0.4});  // a board
  builder.box({0, 0, 0}, {0.4, 0.001, 0.4});
  builder.box({0, 0.8, 0}, {0.4, 0.001, 0.4});  // floor and top make the cells 0.1 m
  Chair chair{"chair_0", builder.mesh("chair_0", {1, 1, 1}), Eigen::Isometry3d::Identity(), 0.4};
  const ChairGrid grid = sense_chair(chair, config);
  const float side = 0.804F / 8;
  EXPECT_NEAR(grid.values[4 * 64], 1 - (grid.centres[4 * 64].y() - 0.43F) / side, 1e-3);
  EXPECT_EQ(grid.values[3 * 64], 0);  // the board is near to this centre, but not in its cell
}

TEST(Voxels, TheChairsGridGoesWithTheRoot) {
  std::mt19937_64 random(3);
  Furniture piece = make_armchair(random);
  const Config config = preset("paper");
  const auto rows = [&](double x, double z, double yaw) {
    piece.place(x, z, yaw);
    const ChairGrid grid = sense_chair(find_chair(scene_of({piece}), "armchair_0"), config);
    const Eigen::Vector2d at = Eigen::Vector2d(x, z) + 1.5 * ahead_of(yaw) + 0.5 * left_of(yaw);
    std::vector<float> out(2048);
    chair_around(grid, place(at.x(), at.y(), yaw + M_PI), out.data());
    return out;
  };
  const std::vector<float> here = rows(0, 0, 0), there = rows(2, -1, 2.1);
  float most = 0;
  for (size_t i = 0; i < 2048; ++i)
    if (i % 4 != 3) most = std::max(most, std::abs(here[i] - there[i]));
  EXPECT_LT(most, 0.03F);    // found by a grid of 2 cm
  EXPECT_GT(here[2], 0.5F);  // the chair is ahead of who looks at it
}

TEST(Surroundings, PreparedTheyAnswerTheSame) {
  const Scene scene = box_scene({0, 1, 0}, {0.5, 1, 0.3});
  const Surroundings later(scene), prepared(scene);
  int asked = 0;
  prepared.prepare([&] { return ++asked == 3; });
  EXPECT_EQ(asked, 3) << "left off where it was told to";
  prepared.prepare();
  Surroundings(floor_scene()).prepare();  // nothing stands there
  for (float x = -1; x <= 1; x += 0.13F)
    for (float y = 0.05F; y < 2.4F; y += 0.21F)
      EXPECT_EQ(prepared.distance({x, y, 0.35F}, 0.5F), later.distance({x, y, 0.35F}, 0.5F));
}

TEST(Surroundings, TheFloorOfAScanIsNotRunInto) {
  MeshBuilder builder;
  builder.box({0, -0.1, 0}, {4, 0.1, 4});     // the floor
  builder.box({2, 0.5, 0}, {0.3, 0.5, 0.3});  // and what stands on it, in one mesh
  Scene scene;
  scene.meshes = {builder.mesh("scan", {0.5F, 0.5F, 0.5F})};
  const Surroundings around(scene);
  EXPECT_GT(around.distance({0, 0.1F, 0}, 1), 0.25F);
  EXPECT_NEAR(around.distance({1.5F, 0.1F, 0}, 1), 0.2F, 0.01F);
  EXPECT_NEAR(around.floor().at({1.2, 0}), 0.5, 0.01);
}

}  // namespace
}  // namespace inhabit::interact
