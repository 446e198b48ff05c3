// Protects residual motion along detours: who is ahead of the baseline has taken its bends; displacements undo
// themselves; tensors say what the plain functions say; a straight leg is told as if there were none.
#include "inhabit/inbetween/detour_legs.h"

#include <gtest/gtest.h>

#include "forecast/walker.h"
#include "inbetween/places_of.h"
#include "inbetween/whole_keys.h"
#include "inhabit/inbetween/baseline.h"
#include "inhabit/inbetween/residual_batch.h"
#include "largest.h"

namespace inhabit::inbetween {
namespace {

using Eigen::Vector3f;
using torch::Tensor;

constexpr int64_t kWindow = 121;

Poses walking_poses() { return poses_of(walker(kWindow, 1.1, 0.7, 1, 2)); }

/// Aside along x and z by a half wave of so many metres between the keys.
Tensor half_wave(double metres) {
  const Tensor wave = torch::sin(torch::arange(kWindow) * (M_PI / 120)) * metres;
  return torch::stack({wave, -wave}, 1);
}

Baseline around(const Poses& motion, double metres) {
  return baseline_of(motion, whole_keys(kWindow, {0, 120}), half_wave(metres));
}

TEST(DetourLegs, WhoIsAheadHasTakenTheBend) {
  const Baseline baseline = around(walking_poses(), 0.6);
  ASSERT_FALSE(baseline.legs.none());
  for (const int64_t t : {20, 50, 90}) {
    const float heading = baseline.heading[static_cast<size_t>(t)];
    float ahead = 0;
    const Vector3f move =
        displacement_to(baseline.legs, baseline.poses, t, heading, baseline.poses.root(t + 15), ahead);
    EXPECT_NEAR(ahead, 15 * baseline.legs.pace[static_cast<size_t>(t)], 1e-4) << t;
    const DisplacedRoot there = displaced(baseline.legs, baseline.poses, t, heading, move);
    EXPECT_LT((there.place - baseline.poses.root(t + 15)).norm(), 1e-4F) << t;
    EXPECT_NEAR(there.yaw, baseline.legs.yaw[static_cast<size_t>(t + 15)] - baseline.legs.yaw[static_cast<size_t>(t)],
                1e-4)
        << t;
  }
  // Four times as far it is half a metre and more beside where the heading frame alone would have put it.
  float ahead = 0;
  const Vector3f move =
      displacement_to(baseline.legs, baseline.poses, 40, baseline.heading[40], baseline.poses.root(100), ahead);
  const Vector3f straight_on =
      baseline.poses.root(40) + Eigen::AngleAxisf(baseline.heading[40], Vector3f::UnitY()) * move;
  EXPECT_GT((straight_on - baseline.poses.root(100)).norm(), 0.5F);
}

TEST(DetourLegs, BeyondItsEndsALegGoesStraightOn) {
  const Baseline baseline = around(walking_poses(), 0.6);
  for (const int64_t t : {10, 110}) {
    const float heading = baseline.heading[static_cast<size_t>(t)];
    const Poses& of = baseline.poses;
    Vector3f place = of.root(0) - 6 * (of.root(1) - of.root(0));
    if (t == 110) place = of.root(120) + 6 * (of.root(120) - of.root(119));
    float ahead = 0;
    const Vector3f move = displacement_to(baseline.legs, baseline.poses, t, heading, place, ahead);
    EXPECT_GT(std::abs(ahead), 0.2F);
    EXPECT_LT((displaced(baseline.legs, baseline.poses, t, heading, move).place - place).norm(), 1e-4F) << t;
  }
}

TEST(DetourLegs, ResidualsUndoThemselves) {
  const Poses motion = walking_poses();
  for (const double metres : {0.2, 0.8, -0.5}) {
    const Baseline baseline = around(motion, metres);
    const Tensor residual = residual_of(motion, baseline);
    EXPECT_LT(residual.select(1, 0).abs().max().item<float>(), 1e-4);
    EXPECT_LT(residual.select(1, 120).abs().max().item<float>(), 1e-4);
    EXPECT_LT(
        largest_difference(places_of(motion_of(residual, torch::ones_like(residual), baseline)), places_of(motion)),
        2e-4)
        << metres;
  }
}

TEST(DetourLegs, StraightOnesAreAsIfThereWereNone) {
  const Poses motion = walking_poses();
  const Baseline straight = baseline_of(motion, whole_keys(kWindow, {0, 120})), hardly = around(motion, 1e-6);
  ASSERT_FALSE(hardly.legs.none());
  EXPECT_TRUE(straight.legs.none());
  EXPECT_LT(largest_difference(residual_of(motion, hardly), residual_of(motion, straight)), 2e-3);
}

TEST(DetourLegs, TensorsSayTheSame) {
  const Poses motion = walking_poses();
  const Baseline bent = around(motion, 0.7), straight = baseline_of(motion, whole_keys(kWindow, {0, 120}));
  const ResidualFrames frames = residual_frames({&bent, &straight}, torch::ones({kScaleRows, kResidualFeatures}));
  torch::manual_seed(5);
  const Tensor residual = 0.4 * torch::randn({2, kResidualFeatures, kWindow}) * (frames.scale > 0);
  const Tensor joints = to_world(frames, residual_joints(frames, residual));
  EXPECT_LT(largest_difference(joints[0], places_of(motion_of(residual[0], frames.scale[0], bent))), 3e-4);
  EXPECT_LT(largest_difference(joints[1], places_of(motion_of(residual[1], frames.scale[1], straight))), 3e-4);
  const Poses there = motion_of(residual[0], frames.scale[0], bent);
  const Tensor points = to_world(frames, guarded_points(frames, residual, residual_joints(frames, residual)))[0];
  EXPECT_LT(largest_difference(points, guarded_places_of(there)), 3e-4);
}

TEST(DetourLegs, AreInBatchesThatAreSampledTwice) {
  const Poses motion = walking_poses();
  const Baseline bent = around(motion, 0.7), straight = baseline_of(motion, whole_keys(kWindow, {0, 120}));
  ResidualBatch batch;
  batch.frames = residual_frames({&bent, &straight}, torch::ones({kScaleRows, kResidualFeatures}));
  torch::manual_seed(7);
  batch.residual = 0.4 * torch::randn({2, kResidualFeatures, kWindow}) * (batch.frames.scale > 0);
  const Tensor rows = torch::zeros({2});
  batch.open = (batch.frames.scale > 0).to(torch::kFloat32);
  for (Tensor* of :
       {&batch.fixed, &batch.bones, &batch.weights, &batch.room, &batch.passes, &batch.feet, &batch.kept, &batch.steps})
    *of = rows;
  const ResidualBatch both = twice(batch, 1);
  const Tensor once = residual_joints(batch.frames, batch.residual),
               again = residual_joints(both.frames, both.residual);
  EXPECT_LT(largest_difference(again.slice(0, 0, 2), once), 1e-6);
  EXPECT_LT(largest_difference(again.slice(0, 2), once), 1e-6);
}

TEST(DetourLegs, HaveGradients) {
  const Baseline baseline = around(walking_poses(), 0.7);
  const ResidualFrames frames = residual_frames({&baseline}, torch::ones({kScaleRows, kResidualFeatures}));
  torch::manual_seed(6);
  const Tensor root = frames.root.to(torch::kDouble), weights = torch::randn({1, kWindow, 3}, torch::kDouble);
  DetourFrames in_double = frames.detours;
  for (Tensor* values :
       {&in_double.from, &in_double.to, &in_double.pace, &in_double.direction, &in_double.yaw, &in_double.heading})
    *values = values->to(torch::kDouble);
  const auto loss = [&](const Tensor& move) {
    const DisplacedRoots there = displaced(in_double, root, move);
    return (there.move * weights).sum() + (there.yaw * weights.select(2, 0)).sum();
  };
  Tensor move = 0.3 * torch::randn({1, kWindow, 3}, torch::kDouble);
  move.requires_grad_(true);
  loss(move).backward();
  const torch::NoGradGuard no_gradients;
  const Tensor direction = torch::randn_like(move);
  const double step = 1e-6;
  const double change = (loss(move + step * direction) - loss(move - step * direction)).item<double>() / (2 * step),
               expected = (move.grad() * direction).sum().item<double>();
  EXPECT_NEAR(change, expected, 1e-4 * std::abs(expected) + 1e-4);
}

}  // namespace
}  // namespace inhabit::inbetween
