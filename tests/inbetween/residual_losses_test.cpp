// Protects the energy score that the denoiser is tuned by as it is deployed: least where samples are distributed as the
// truth is, with the value that normal distributions have. And what is said of feet that slide, and of what is in
// walls.
#include "inhabit/inbetween/residual_losses.h"

#include <gtest/gtest.h>

#include "inhabit/inbetween/residual_batch.h"
#include "inhabit/scene/shapes.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

double score(double mean, double deviation) {
  torch::manual_seed(1);
  const int64_t count = 400'000;
  const auto draw = [&] { return torch::randn({count, 1}, torch::kDouble); };
  const Tensor truth = draw(), a = mean + deviation * draw(), b = mean + deviation * draw();
  return energy_score(a, b, truth, 0).mean().item<double>();
}

TEST(EnergyScore, IsThatOfNormalDistributions) {
  // E|y - x| = 2 / sqrt(pi) of two standard normals: less half of the same.
  EXPECT_NEAR(score(0, 1), 1 / std::sqrt(M_PI), 3e-3);
  // All samples at 0: E|x| = sqrt(2 / pi).
  EXPECT_NEAR(score(0, 0), std::sqrt(2 / M_PI), 3e-3);
}

TEST(EnergyScore, IsLeastForTheTrueDistribution) {
  const double best = score(0, 1);
  for (const double deviation : {0.0, 0.5, 0.8, 1.3, 2.0}) EXPECT_GT(score(0, deviation), best + 3e-3) << deviation;
  for (const double mean : {-0.5, 0.3}) EXPECT_GT(score(mean, 1), best + 3e-3) << mean;
}

TEST(EnergyScore, HasGradientsWhereSamplesMeet) {
  Tensor a = torch::zeros({1, 3}), b = torch::zeros({1, 3});
  a.requires_grad_(true);
  b.requires_grad_(true);
  energy_score(a, b, torch::zeros({1, 3}), 0.05).sum().backward();
  EXPECT_TRUE(a.grad().isfinite().all().item<bool>());
}

/// Feet at a height, going by so much a frame; all else far above.
Tensor going(double height, double speed) {
  Tensor joints = torch::full({1, 20, 22, 3}, 1.0);
  for (const int64_t joint : {7, 8, 10, 11}) {
    joints.select(2, joint).select(2, 1).fill_(height);
    joints.select(2, joint).select(2, 2) += speed * torch::arange(20);
  }
  return joints;
}

double slides(double height, double speed) {
  return sliding_loss(going(height, speed), torch::ones({1, 19, 1})).item<double>();
}

TEST(SlidingLoss, IsOfFeetThatAreLowAndGo) {
  EXPECT_LT(slides(0, 0), 1e-6);
  EXPECT_LT(slides(0, 0.008), 1e-6);    // what is measured of feet that stand
  EXPECT_LT(slides(0.15, 0.05), 1e-3);  // a foot that swings
  // At 5 cm half of it counts: 0.5 (sqrt(1 + ((0.048 - 0.008) / 0.02)^2) - 1).
  EXPECT_NEAR(slides(0.05, 0.048), 0.5 * (std::sqrt(5.0) - 1), 1e-3);
  EXPECT_GT(slides(0, 0.05), slides(0, 0.03));
}

TEST(SlidingLoss, SlowsFeetDownAndLiftsThem) {
  Tensor joints = going(0.04, 0.03);
  joints.requires_grad_(true);
  sliding_loss(joints, torch::ones({1, 19, 1})).backward();
  EXPECT_TRUE(joints.grad().isfinite().all().item<bool>());
  EXPECT_LT(joints.grad()[0][9][10][1].item<double>(), 0);   // higher is better
  EXPECT_GT(joints.grad()[0][19][10][2].item<double>(), 0);  // the last one goes too far
  EXPECT_EQ(joints.grad()[0][9][3].abs().max().item<double>(), 0);
  EXPECT_EQ(sliding_loss(joints, torch::zeros({1, 19, 1})).item<double>(), 0);  // between keys alone
}

double swings(double speed, double true_speed) {
  return swinging_loss(going(0.1, speed), going(0.1, true_speed), torch::ones({1, 19, 1})).item<double>();
}

TEST(SwingingLoss, IsOfFeetThatGoFasterThanTheTruthEverDoes) {
  EXPECT_LT(swings(0.12, 0.12), 1e-6);
  EXPECT_EQ(swings(0.05, 0.12), 0);
  EXPECT_NEAR(swings(0.16, 0.12), std::sqrt(5.0) - 1, 1e-3);
  EXPECT_EQ(swings(0.08, 0), 0) << "a calm step where the truth stands";
  EXPECT_NEAR(swings(0.1, 0), std::sqrt(2.0) - 1, 1e-3);
}

TEST(SwingingLoss, TakesTheFastestFootOfAWindowAsItsLimit) {
  Tensor truth = going(0.1, 0.05);
  truth[0].slice(0, 10).select(1, 8).select(1, 2) += 0.1;  // one step of one ankle
  EXPECT_LT(swinging_loss(going(0.1, 0.15), truth, torch::ones({1, 19, 1})).item<double>(), 1e-6);
  EXPECT_GT(swinging_loss(going(0.1, 0.16), truth, torch::ones({1, 19, 1})).item<double>(), 0.1);
  const Tensor both = torch::cat({truth, going(0.1, 0.05)});  // of each window by itself
  EXPECT_GT(
      swinging_loss(torch::cat({going(0.1, 0.05), going(0.1, 0.15)}), both, torch::ones({2, 19, 1})).item<double>(),
      0.1);
}

TEST(SwingingLoss, SlowsFeetDown) {
  Tensor joints = going(0.1, 0.15);
  joints.requires_grad_(true);
  swinging_loss(joints, going(0.1, 0.1), torch::ones({1, 19, 1})).backward();
  EXPECT_TRUE(joints.grad().isfinite().all().item<bool>());
  EXPECT_GT(joints.grad()[0][19][10][2].item<double>(), 0);  // the last one goes too far
  EXPECT_LT(joints.grad()[0][0][10][2].item<double>(), 0);
}

/// A wall that begins at x = 0.5.
std::vector<SceneDistances> beside_a_wall() {
  Scene room = floor_scene();
  MeshBuilder wall;
  wall.box({0.7, 1, 0}, {0.2, 1, 1});
  room.meshes.push_back(wall.mesh("wall", {0.5F, 0.5F, 0.5F}));
  return {SceneDistances(room)};
}

/// One frame of a body at x = 0 whose left palm is `gap` metres before the wall.
Tensor reaching(double gap) {
  Tensor points = torch::zeros({1, 1, guarded_radii().size(0), 3});
  points.select(3, 1).fill_(1);
  points[0][0][kBodyPoints][0] = 0.5 - gap;
  return points;
}

double inside(const Tensor& points, double kept = 1) {
  return penetration_loss(beside_a_wall(), points, guarded_radii().view({1, 1, -1}), torch::full({1}, kept))
      .item<double>();
}

TEST(PenetrationLoss, IsOfPointsNearerThanTheirRoom) {
  const double free = limb_ends()[0].radius;
  EXPECT_LT(inside(reaching(free + 0.1)), 1e-6);
  EXPECT_NEAR(inside(reaching(free - 0.05)), 1, 0.05);
  EXPECT_NEAR(inside(reaching(-0.03)), std::pow((free + 0.03) / 0.05, 2), 0.2) << "inside the wall";
  EXPECT_EQ(inside(reaching(-0.03), 0), 0) << "the scene is hidden";
  Tensor points = reaching(0.02).requires_grad_(true);
  penetration_loss(beside_a_wall(), points, guarded_radii().view({1, 1, -1}), torch::ones({1})).backward();
  EXPECT_EQ(points.grad()[0][0][0].abs().max().item<double>(), 0) << "the pelvis is free";
  const double step = 1e-3, slope = (inside(reaching(0.02 - step)) - inside(reaching(0.02 + step))) / (2 * step);
  EXPECT_GT(slope, 0) << "away from the wall is better";
  EXPECT_NEAR(points.grad()[0][0][kBodyPoints][0].item<double>(), slope, 0.05 * slope);
}

/// One frame of a root that is `gap` metres before the wall, whose truth keeps 0.4 m.
double near_wall(double gap, double kept = 1) {
  const Tensor root = torch::tensor({0.5 - gap, 0.9, 0.0}).view({1, 1, 3});
  return clearance_loss(beside_a_wall(), root, torch::full({1, 1, 3}, 0.4), torch::full({1}, kept)).item<double>();
}

TEST(ClearanceLoss, IsOfRootsThatPassNearerThanTheTrueOne) {
  EXPECT_LT(near_wall(0.42), 1e-3);
  EXPECT_NEAR(near_wall(0.3), std::sqrt(2.0) - 1, 0.02);
  EXPECT_NEAR(near_wall(0.1), std::sqrt(10.0) - 1, 0.05);
  EXPECT_EQ(near_wall(0.1, 0), 0) << "the scene is hidden";
  Tensor root = torch::tensor({0.3, 0.9, 0.0}).view({1, 1, 3}).requires_grad_(true);
  clearance_loss(beside_a_wall(), root, torch::full({1, 1, 3}, 0.4), torch::ones({1})).backward();
  const double step = 1e-3, slope = (near_wall(0.2 - step) - near_wall(0.2 + step)) / (2 * step);
  EXPECT_GT(slope, 0) << "away from the wall is better";
  EXPECT_NEAR(root.grad()[0][0][0].item<double>(), slope, 0.05 * slope);
  EXPECT_EQ(root.grad()[0][0][1].item<double>(), 0) << "at any height";
}

TEST(PassingDistance, IsTheLeastOfHalfASecondBeforeAndAfter) {
  // Towards the wall and away again, nearest at frame 30: 0.1 m.
  const Tensor gap = 0.1 + 0.02 * (torch::arange(61) - 30).abs();
  const Tensor root = torch::stack({0.5 - gap, torch::full({61}, 0.9), torch::zeros({61})}, 1).unsqueeze(0);
  const Tensor passes = passing_distance(beside_a_wall(), root);
  ASSERT_EQ(passes.sizes(), torch::IntArrayRef({1, 61, 3}));
  for (const int64_t t : {15, 22, 30, 45}) EXPECT_NEAR(passes[0][t][1].item<double>(), 0.1, 0.02) << t;
  EXPECT_NEAR(passes[0][10][1].item<double>(), 0.2, 0.02) << "at frame 25";
  EXPECT_NEAR(passes[0][0][1].item<double>(), 0.4, 1e-6) << "0.4 m from frame 15 on";
  EXPECT_NEAR(passes[0][60][1].item<double>(), 0.4, 1e-6);
}

}  // namespace
}  // namespace inhabit::inbetween
