// Protects what PathNet sees and says: the map in the line's axes, paths that begin and end at the keys, and a training
// that brings its paths out of what stands in the way.
#include "inhabit/inbetween/path_net.h"

#include <gtest/gtest.h>

#include <cmath>

#include "inhabit/inbetween/train_path.h"
#include "inhabit/scene/shapes.h"

namespace inhabit::inbetween {
namespace {

using Eigen::Vector2d;
using torch::Tensor;

/// A box of 0.8 x 1 x 0.4 m (x, y, z) that stands at (1, 2).
SceneDistances scene_with_box() {
  Scene scene = floor_scene();
  MeshBuilder box;
  box.box({1, 0.5, 2}, {0.4, 0.5, 0.2});
  scene.meshes.push_back(box.mesh("box", {0.5F, 0.5F, 0.5F}));
  return SceneDistances(scene);
}

TEST(PathNet, TellsPlacesInTheLinesAxes) {
  const PathLine line{{1, 0}, {1, 4}};  // ahead is +Z
  EXPECT_EQ(line.length(), 4);
  EXPECT_LT((line.world(-2, 0) - line.from).norm(), 1e-12);
  EXPECT_LT((line.world(2, 0) - line.to).norm(), 1e-12);
  EXPECT_LT((line.world(0, 0.5) - Vector2d(1.5, 2)).norm(), 1e-12) << "to the side: +X";
  const PathLine other{{0.3, -0.2}, {-1.1, 0.7}};
  const Vector2d ahead = other.world(1, 0) - other.world(0, 0), aside = other.world(0, 1) - other.world(0, 0);
  EXPECT_NEAR(ahead.norm(), 1, 1e-12);
  EXPECT_NEAR(aside.norm(), 1, 1e-12);
  EXPECT_NEAR(ahead.dot(aside), 0, 1e-12);
}

TEST(PathNet, SeesWhatStandsBesideTheLine) {
  const SceneDistances scene = scene_with_box();
  const PathLine line{{0.4, 0}, {0.4, 4}};  // the box is 0.2 to 1 m to its side, u from -0.2 to 0.2
  const Tensor map = path_map(scene, line);
  ASSERT_EQ(map.sizes(), torch::IntArrayRef({kMapWide, kMapLong}));
  const auto at = [&](double u, double v) {
    Tensor place = torch::tensor({u, v}, torch::kFloat32).view({1, 1, 1, 2});
    return at_places(map.view({1, 1, kMapWide, kMapLong}), place).item<double>();
  };
  EXPECT_EQ(at(0, 0.6), 0) << "inside";
  EXPECT_NEAR(at(0, 0), (0.2 - 0.05) / 0.75, 0.06) << "0.2 m away";
  EXPECT_NEAR(at(0, -0.3), (0.5 - 0.05) / 0.75, 0.06);
  EXPECT_EQ(at(0, -1), 1) << "far on the other side";
  EXPECT_EQ(at(-1.5, 0), 1) << "and before it";
  EXPECT_FALSE(line_blocked(scene, line));
  EXPECT_TRUE(line_blocked(scene, {{0.5, 0}, {0.5, 4}})) << "0.1 m away";
  EXPECT_TRUE(line_blocked(scene, {{1, 0}, {1, 4}}));
  EXPECT_FALSE(line_blocked(scene, {{1, 1.6}, {1, 2.4}})) << "near the keys somebody may sit on it";
}

TEST(PathNet, PathsLeaveFromOneKeyAndEndAtTheNext) {
  const Tensor sines = torch::zeros({1, 2, kPathSines});
  sines[0][1][0] = 0.6;
  sines[0][0][2] = -0.1;
  const Tensor times = torch::tensor({0.F, 0.25F, 0.5F, 1.F}), offsets = path_offsets(sines, times)[0];
  for (const int64_t end : {0, 3}) EXPECT_LT(offsets[end].abs().max().item<double>(), 1e-6);
  EXPECT_NEAR(offsets[1][1].item<double>(), 0.6 * std::sin(M_PI / 4), 1e-6);
  EXPECT_NEAR(offsets[1][0].item<double>(), -0.1 * std::sin(3 * M_PI / 4), 1e-6);
  EXPECT_NEAR(offsets[2][1].item<double>(), 0.6, 1e-6);
  // At PathNet's times the sines are orthogonal, which is how a round's moves become sines again.
  const Tensor basis = torch::sin(torch::arange(1, kPathSines + 1).unsqueeze(1) * M_PI * path_times());
  const Tensor products = basis.matmul(basis.t()) * (2. / kPathPoints);
  EXPECT_LT((products - torch::eye(kPathSines)).abs().max().item<double>(), 1e-5);
}

TEST(PathNet, DrawnFloorsHaveADetourThatKeepsClear) {
  const DrawnFloors floors = draw_floors(24, 5), again = draw_floors(24, 5), others = draw_floors(24, 6);
  EXPECT_TRUE(torch::equal(floors.offsets, again.offsets)) << "the same seed, the same floors";
  EXPECT_FALSE(torch::equal(floors.offsets, others.offsets));
  const Tensor along = (path_times() - 0.5) * floors.length.unsqueeze(1);
  const Tensor straight = torch::stack({along, torch::zeros_like(along)}, 2);
  const auto clearance = [&](const Tensor& places) {
    return at_places(floors.distance.unsqueeze(1), places.unsqueeze(1)).view({24, kPathPoints});
  };
  const Tensor ends = torch::minimum(path_times(), 1 - path_times()) * floors.length.unsqueeze(1);
  const Tensor inner = ends > 0.75, path = clearance(straight + floors.offsets), line = clearance(straight);
  EXPECT_GT(path.masked_select(inner).min().item<double>(), 0.1);
  EXPECT_TRUE((line.amin(1) < 0.25).all().item<bool>()) << "all lines are blocked";
  EXPECT_LT(floors.offsets.select(1, 0).abs().max().item<double>(), 0.25) << "they leave from the key";
}

TEST(PathNet, LearnsToGoAround) {
  torch::manual_seed(2);
  PathNet network;
  network->train();
  torch::optim::Adam optimizer(network->parameters(), 2e-3);
  const DrawnFloors unseen = draw_floors(24, 1000);
  const auto measured = [&] {
    const torch::NoGradGuard no_gradients;
    network->eval();
    const Losses losses = path_losses(network, unseen);
    network->train();
    return std::pair(losses.at(0).second.item<double>(), losses.at(3).second.item<double>());
  };
  const auto before = measured();
  for (uint64_t step = 0; step < 50; ++step) {
    const Losses losses = path_losses(network, draw_floors(8, step));
    optimizer.zero_grad();
    losses.front().second.backward();
    optimizer.step();
  }
  const auto after = measured();
  EXPECT_LT(after.first, 0.6 * before.first) << "loss";
  EXPECT_LT(after.second, 0.5 * before.second) << "fraction of points that touch something";
}

}  // namespace
}  // namespace inhabit::inbetween
