#include "inhabit/scene/occupancy.h"

#include <gtest/gtest.h>

#include "inhabit/error.h"
#include "inhabit/math/rotation.h"
#include "inhabit/scene/query.h"
#include "shapes.h"

namespace inhabit {
namespace {

TEST(Occupancy, BoxIsFilledExactly) {
  // Cells are [-1, -0.9), ...: the box spans [-0.33, 0.42] x [-0.2 (inside a cell), ...].
  const Solid solid = make_solid(scene_of({box_mesh({0.045, 0.01, -0.02}, {0.75, 0.5, 0.3})}));
  const OccupancyShape shape{{20, 20, 20}, 0.1};
  const torch::Tensor grid = occupancy_grid(solid, {0, 0, 0}, 0, shape);
  ASSERT_EQ(grid.sizes(), (torch::IntArrayRef{20, 20, 20}));
  const auto range = [](double low, double high) {
    return std::pair{static_cast<int64_t>(std::floor((low + 1) * 10)),
                     static_cast<int64_t>(std::floor((high + 1) * 10)) + 1};
  };
  const auto [x0, x1] = range(0.045 - 0.375, 0.045 + 0.375);
  const auto [y0, y1] = range(0.01 - 0.25, 0.01 + 0.25);
  const auto [z0, z1] = range(-0.02 - 0.15, -0.02 + 0.15);
  torch::Tensor expected = torch::full({20, 20, 20}, -1.F);
  expected.slice(0, x0, x1).slice(1, y0, y1).slice(2, z0, z1).fill_(1);
  EXPECT_TRUE(torch::equal(grid, expected));
}

TEST(Occupancy, InsideAgreesWithTheQuery) {
  const Scene scene = scene_of({sphere_mesh({0.1, 0.05, 0}, 0.6, 24), box_mesh({0.5, 0, 0}, {0.7, 0.9, 0.7}),
                                flipped(box_mesh({-0.6, -0.5, -0.5}, {0.5, 0.5, 0.5}, {3}))});
  const OccupancyShape shape{{40, 40, 40}, 0.05};
  const Solid solid = make_solid(scene);
  const torch::Tensor grid = occupancy_grid(solid, {0, 0, 0}, 0, shape);
  const torch::Tensor steps = (torch::arange(40) + 0.5) * 0.05 - 1;
  const std::vector<torch::Tensor> axes = torch::meshgrid({steps, steps, steps}, "ij");
  const torch::Tensor middles =
      torch::stack({axes[0].reshape({-1}), axes[1].reshape({-1}), axes[2].reshape({-1})}, 1).to(torch::kFloat32);
  const SceneQuery query(scene);
  const torch::Tensor distance = query.closest(middles).distances, inside = query.inside(middles);
  const torch::Tensor filled = grid.view({-1}) > 0;
  // No surface within half a cell of the middle, none in the cell beyond half its diagonal.
  EXPECT_TRUE(filled.index({distance < 0.0249}).all().item<bool>());
  const torch::Tensor clear = distance > 0.0434;
  const torch::Tensor differ = filled.index({clear}) != inside.index({clear});
  EXPECT_LT(differ.to(torch::kFloat32).mean().item<float>(), 0.002F);  // near the rim of the box without a lid
}

TEST(Occupancy, LargeSlantedFacesFillEveryCellTheyPass) {
  torch::manual_seed(3);
  const OccupancyShape shape{{30, 30, 30}, 0.1};
  for (int i = 0; i < 20; ++i) {
    Mesh face{"face", (torch::rand({3, 3}) - 0.5) * 3.4F, torch::tensor({{0, 1, 2}})};
    if (i == 0) face.vertices.select(1, 1).fill_(0.31F);  // level
    if (i == 1) face.vertices[2] = face.vertices[1];      // a line
    const torch::Tensor grid = occupancy_grid(make_solid(scene_of({face})), {0, 0, 0}, 0.3, shape);
    // Points of the face, spread evenly, seen along the grid's axes.
    const torch::Tensor r = torch::rand({20000, 2}).sqrt(), a = r.select(1, 0), b = torch::rand({20000}) * a;
    const torch::Tensor points = ((1 - a).unsqueeze(1) * face.vertices[0] + (a - b).unsqueeze(1) * face.vertices[1] +
                                  b.unsqueeze(1) * face.vertices[2])
                                     .matmul(yaw_matrix(0.3));
    const torch::Tensor cells = ((points + 1.5) / 0.1).floor().to(torch::kInt64);
    const torch::Tensor there = cells.ge(0).logical_and(cells.lt(30)).all(1);
    const torch::Tensor at = cells.index({there});
    EXPECT_TRUE(grid.index({at.select(1, 0), at.select(1, 1), at.select(1, 2)}).gt(0).all().item<bool>()) << i;
    const torch::Tensor full = grid.gt(0).nonzero();
    if (full.size(0) == 0) continue;
    const torch::Tensor middles = ((full + 0.5) * 0.1 - 1.5).to(torch::kFloat32).matmul(yaw_matrix(0.3).t());
    EXPECT_LT(SceneQuery(scene_of({face})).closest(middles.contiguous()).distances.max().item<double>(), 0.08661) << i;
  }
}

TEST(Occupancy, WallInFrontStaysInFront) {
  // A wall 1 m ahead of a person at (2, 0.9, -1), whatever way the person faces.
  for (const double heading : {0.0, 0.5, 1.5707963267948966, 2.9, -2.2}) {
    const double x = 2 + std::sin(heading), z = -1 + std::cos(heading);
    Mesh wall = box_mesh({0, 0.9, 0}, {6, 2, 0.02});
    const torch::Tensor rotation =
        torch::tensor({std::cos(heading), 0., std::sin(heading), 0., 1., 0., -std::sin(heading), 0., std::cos(heading)},
                      torch::kFloat32)
            .view({3, 3});
    wall.vertices = torch::matmul(wall.vertices, rotation.t()) + torch::tensor({x, 0., z}, torch::kFloat32);
    const torch::Tensor grid = occupancy_grid(make_solid(scene_of({wall})), {2, 0.9, -1}, heading);
    ASSERT_EQ(grid.sizes(), (torch::IntArrayRef{48, 24, 48}));
    // 1 m ahead is cell 24 + 10, or the one before it.
    const torch::Tensor filled = grid > 0;
    EXPECT_TRUE((filled.select(2, 33) | filled.select(2, 34)).slice(1, 3, 21).all().item<bool>()) << heading;
    EXPECT_FALSE(filled.slice(2, 0, 33).any().item<bool>()) << heading;
    EXPECT_FALSE(filled.slice(2, 35, 48).any().item<bool>()) << heading;
  }
}

TEST(Occupancy, LeftIsLargeX) {
  // Faces +X: the left is then -Z.
  const Scene scene = scene_of({box_mesh({0, 0, -1}, {0.2, 0.2, 0.2})});
  const torch::Tensor filled =
      (occupancy_grid(make_solid(scene), {0, 0, 0}, M_PI / 2) > 0).nonzero().to(torch::kFloat32).mean(0);
  EXPECT_NEAR(filled[0].item<float>(), 33.5, 0.6);
  EXPECT_NEAR(filled[1].item<float>(), 11.5, 0.6);
  EXPECT_NEAR(filled[2].item<float>(), 23.5, 0.6);
}

TEST(Occupancy, OverlappingAndFlippedBoxes) {
  const Scene scene = scene_of({box_mesh({0, 0, 0}, {1, 1, 1}), flipped(box_mesh({0.4, 0.3, 0}, {1, 1, 1}))});
  const torch::Tensor grid = occupancy_grid(make_solid(scene), {0, 0, 0}, 0.3);
  EXPECT_EQ(grid[25][13][24].item<float>(), 1);
  EXPECT_EQ(grid[20][10][24].item<float>(), 1);
}

TEST(Occupancy, FarSceneIsAirAndRoomsAreHollow) {
  const torch::Tensor far = occupancy_grid(make_solid(floor_scene()), {500, 0, 0}, 0);
  EXPECT_TRUE((far == -1).all().item<bool>());
  const torch::Tensor room =
      occupancy_grid(make_solid(scene_of({flipped(box_mesh({0, 1.25, 0}, {4, 2.5, 4}))})), {0, 0.9, 0}, 0.7);
  EXPECT_EQ(room[24][12][24].item<float>(), -1);
  EXPECT_LT((room > 0).to(torch::kFloat32).mean().item<float>(), 0.25F);
  Scene cloud;
  cloud.points = torch::tensor({0.05F, 0.05F, 0.05F, 9.F, 9.F, 9.F}).view({2, 3});
  const torch::Tensor points = occupancy_grid(make_solid(cloud), {0, 0, 0}, 0);
  EXPECT_EQ((points > 0).sum().item<int64_t>(), 1);
  EXPECT_EQ(points[24][12][24].item<float>(), 1);
}

TEST(Occupancy, BadShapes) {
  const Solid solid = make_solid(floor_scene());
  EXPECT_THROW(occupancy_grid(solid, {0, 0, 0}, 0, {{0, 1, 1}, 0.1}), Error);
  EXPECT_THROW(occupancy_grid(solid, {0, 0, 0}, 0, {{4096, 4096, 4096}, 0.1}), Error);
  EXPECT_THROW(occupancy_grid(solid, {NAN, 0, 0}, 0), Error);
}

}  // namespace
}  // namespace inhabit
