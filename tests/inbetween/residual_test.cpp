// Protects residual motion: poses, their mirror image and clips are the same thing told in several ways; the baseline
// is linear + slerp; residuals are nothing at keys, undo themselves and know neither the scene's axes nor rest frames.
#include "inhabit/inbetween/residual.h"

#include <gtest/gtest.h>

#include "forecast/walker.h"
#include "inbetween/places_of.h"
#include "inbetween/whole_keys.h"
#include "inhabit/inbetween/interpolate.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/scene_probe.h"
#include "inhabit/math/random.h"
#include "inhabit/motion/canonical.h"
#include "largest.h"

namespace inhabit::inbetween {
namespace {

using Eigen::AngleAxisf;
using Eigen::Quaternionf;
using Eigen::Vector3f;
using torch::Tensor;

constexpr int64_t kFrames = 121;

Clip someone() { return walker(kFrames, 1.1, 0.7, 1, 2); }

float largest_distance(const Poses& a, const Poses& b) {
  float out = 0;
  for (size_t i = 0; i < a.joints.size(); ++i) out = std::max(out, (a.joints[i] - b.joints[i]).norm());
  return out;
}

TEST(Poses, GoToClipsAndBack) {
  const Clip clip = someone();
  const Poses poses = poses_of(clip, 0.2);
  EXPECT_LT(largest_difference(places_of(poses), clip.joints - torch::tensor({0.F, 0.2F, 0.F})), 1e-5);
  const Clip back = clip_of(poses, clip, 0.2);
  EXPECT_LT(largest_difference(back.joints, clip.joints), 1e-5);
  EXPECT_LT(largest_difference(back.rotations, clip.rotations), 1e-4);
  EXPECT_LT(largest_difference(back.trans, clip.trans), 1e-5);
}

TEST(Poses, FaceAsTheirClipDoesUnlessTheyLie) {
  const Clip clip = someone();
  Poses poses = poses_of(clip);
  const Tensor expected = headings(clip.joints);
  for (const int64_t t : {0, 60, 120})
    EXPECT_NEAR(heading_of(poses, t, 9), expected[t].item<double>(), 1e-5) << "frame " << t;
  for (const int64_t j : {1, 2, 16, 17}) poses.joints[Poses::at(60, j)] = Vector3f(0, static_cast<float>(j), 0);
  EXPECT_EQ(heading_of(poses, 60, 9), 9) << "the lines between hips and shoulders are vertical";
}

TEST(Poses, AMirrorShowsTheOtherSide) {
  const Poses poses = poses_of(someone());
  const Poses mirrored = window_of(poses, 10, 50, true);
  ASSERT_EQ(mirrored.frames(), 50);
  for (const auto& [left, right] : {std::pair{7, 8}, {20, 21}, {0, 0}, {15, 15}}) {
    const Vector3f there = poses.joints[Poses::at(13, right)], here = mirrored.joints[Poses::at(3, left)];
    EXPECT_LT((here - Vector3f(-there.x(), there.y(), there.z())).norm(), 1e-5);
  }
  Poses moved = mirrored;  // rotations and offsets are mirrored along
  for (int64_t t = 0; t < moved.frames(); ++t) place_joints(moved, t);
  EXPECT_LT(largest_distance(moved, mirrored), 1e-5F);
  EXPECT_LT(largest_distance(window_of(mirrored, 0, 50, true), window_of(poses, 10, 50)), 1e-5F);
}

TEST(Poses, AtAnotherPaceAreWhereTheMotionIsThen) {
  const Poses poses = poses_of(someone());
  const Poses same = at_pace(poses, kFrames, 1);
  EXPECT_LT(largest_distance(same, poses), 1e-5F);
  const Poses fast = at_pace(poses, 61, 2);  // every second frame
  ASSERT_EQ(fast.frames(), 61);
  for (const int64_t t : {0, 7, 33, 60})
    for (const int64_t j : {0, 7, 20})
      EXPECT_LT((fast.joints[Poses::at(t, j)] - poses.joints[Poses::at(2 * t, j)]).norm(), 1e-5F) << t << " " << j;
  const Poses slow = at_pace(poses, kFrames, 0.8);
  // Between frames: near both, with the bones' lengths.
  const Vector3f knee = slow.joints[Poses::at(6, 4)], ankle = slow.joints[Poses::at(6, 7)];
  EXPECT_NEAR((knee - ankle).norm(), poses.offsets[7].norm(), 1e-5);
  const Vector3f between = 0.2F * poses.joints[Poses::at(4, 4)] + 0.8F * poses.joints[Poses::at(5, 4)];  // 6 x 0.8
  EXPECT_LT((knee - between).norm(), 2e-3F);
  EXPECT_GT((poses.joints[Poses::at(5, 4)] - poses.joints[Poses::at(4, 4)]).norm(), 0.01F) << "it moves";
}

TEST(Baseline, IsLinearAndSlerp) {
  const Clip clip = someone();
  const std::vector<int64_t> keys = {0, 37, 60, 120};
  const Baseline baseline = baseline_of(poses_of(clip), whole_keys(kFrames, keys));
  EXPECT_LT(largest_difference(places_of(baseline.poses), interpolate_linear(clip, keys).joints), 1e-4);
}

TEST(Poses, NoiseIsAsLargeAsItsLevelSays) {
  const Poses poses = poses_of(someone());
  std::mt19937_64 random(11);
  const Poses noisy = with_noise(poses, 2, random);
  double moved = 0, turned = 0;
  for (int64_t t = 0; t < kFrames; ++t) {
    moved += static_cast<double>((noisy.root(t) - poses.root(t)).squaredNorm());
    for (int64_t j = 0; j < kStandardJoints; ++j)
      turned += std::pow(local_rotation(noisy, t, j).angularDistance(local_rotation(poses, t, j)), 2);
  }
  EXPECT_NEAR(std::sqrt(moved / (3 * kFrames)), 0.02, 0.002);
  EXPECT_NEAR(std::sqrt(turned / (3 * kFrames * kStandardJoints)) * 180 / M_PI, 2, 0.1);
}

// Noisy keys are open, exact ones are not; what the truth does beyond the smoothed keys is told whole.
TEST(Baseline, OfNoisyKeysIsSmoothAndLeavesThemOpen) {
  const Poses truth = poses_of(someone());
  std::mt19937_64 random(12);
  Poses keys = with_noise(truth, 1, random);
  KeyNoise noise{1, std::vector<char>(kFrames, 0), 30};
  for (const int64_t end : {0, 120}) {
    noise.exact[static_cast<size_t>(end)] = 1;
    for (int64_t j = 0; j < kStandardJoints; ++j) {
      keys.joints[Poses::at(end, j)] = truth.joints[Poses::at(end, j)];
      keys.rotations[Poses::at(end, j)] = truth.rotations[Poses::at(end, j)];
    }
  }
  const Tensor groups = whole_keys(kFrames, key_frames("every:3", kFrames));
  const Baseline plain = baseline_of(keys, groups), smooth = baseline_of(keys, groups, {}, noise);
  const auto error = [&](const Baseline& baseline) {
    return (places_of(baseline.poses) - places_of(truth)).norm(2, {2}).mean().item<double>();
  };
  EXPECT_LT(error(smooth), 0.95 * error(plain));
  EXPECT_EQ(smooth.noise[0], 0);
  EXPECT_EQ(smooth.noise[61], 1);
  EXPECT_TRUE(smooth.poses.rotations[Poses::at(120, 5)].coeffs() == truth.rotations[Poses::at(120, 5)].coeffs());
  const Tensor scale = residual_scale(
      smooth, torch::rand({kScaleRows, kResidualFeatures}) * (torch::arange(kScaleRows) > 0).unsqueeze(1));
  EXPECT_EQ(scale.select(1, 120).abs().max().item<double>(), 0);
  EXPECT_GT(scale.select(1, 60).min().item<double>(), 0.001);
  // The key's own joints are told as targets.
  const size_t wrist = Poses::at(60, 21);
  const Vector3f away =
      AngleAxisf(-smooth.heading[60], Vector3f::UnitY()) * (keys.joints[wrist] - smooth.poses.joints[wrist]);
  EXPECT_EQ(smooth.targets[60][21][3].item<float>(), 1);
  EXPECT_EQ(smooth.targets[120][21][3].item<float>(), 0);
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(smooth.targets[60][21][axis].item<float>(), away[axis], 1e-6);
  const Poses back = motion_of(residual_of(truth, smooth), torch::ones({kResidualFeatures, kFrames}), smooth);
  EXPECT_LT(largest_distance(back, truth), 1e-3F);
}

TEST(Baseline, KnowsHowFarKeysAre) {
  const Baseline baseline = baseline_of(poses_of(someone()), whole_keys(kFrames, {0, 40, 80}));
  EXPECT_EQ(baseline.pose_distance[10].bridge(), 7.5F) << "10 * 30 / 40";
  EXPECT_EQ(baseline.pose_distance[40].bridge(), 0);
  EXPECT_EQ(baseline.pose_distance[100].before, 20);
  EXPECT_EQ(baseline.pose_distance[100].after, -1);
}

TEST(Baseline, PartialKeysAreTargets) {
  const Clip clip = someone();
  Tensor groups = whole_keys(kFrames, {0, 120});
  groups[50][kJointGroups + 20] = 1;  // the left wrist
  const Baseline baseline = baseline_of(poses_of(clip), groups);
  EXPECT_EQ(baseline.targets.select(2, 3).sum().item<float>(), 1);
  const Tensor target = baseline.targets[50][20];
  const Vector3f away(target[0].item<float>(), target[1].item<float>(), target[2].item<float>());
  const Vector3f there =
      baseline.poses.joints[Poses::at(50, 20)] + AngleAxisf(baseline.heading[50], Vector3f::UnitY()) * away;
  EXPECT_LT((there - poses_of(clip).joints[Poses::at(50, 20)]).norm(), 1e-5);
}

TEST(Residual, UndoesItselfAndIsNothingAtKeys) {
  const Poses motion = poses_of(someone());
  const Baseline baseline = baseline_of(motion, whole_keys(kFrames, {0, 60, 120}));
  const Tensor residual = residual_of(motion, baseline);
  ASSERT_EQ(residual.sizes(), torch::IntArrayRef({kResidualFeatures, kFrames}));
  for (const int64_t key : {0, 60, 120}) EXPECT_LT(residual.select(1, key).abs().max().item<float>(), 1e-4) << key;
  EXPECT_GT(residual.select(1, 30).abs().max().item<float>(), 0.005);
  EXPECT_LT(largest_distance(motion_of(residual, torch::ones_like(residual), baseline), motion), 1e-4F);
  // As the network's losses see it.
  ResidualFrames frames = residual_frames({&baseline}, torch::ones({kScaleRows, kResidualFeatures}));
  const Tensor joints = to_world(frames, residual_joints(frames, residual.unsqueeze(0)))[0];
  EXPECT_LT(largest_difference(joints, places_of(motion)), 1e-4);
}

TEST(Residual, KnowsNoAxesOfTheScene) {
  const Poses motion = poses_of(someone());
  Poses turned = motion;
  const Quaternionf rotation(AngleAxisf(2.1F, Vector3f::UnitY()));
  for (Vector3f& joint : turned.joints) joint = rotation * joint + Vector3f(3, 0, -1);
  for (Quaternionf& q : turned.rotations) q = rotation * q;
  const Tensor keys = whole_keys(kFrames, {0, 60, 120});
  EXPECT_LT(largest_difference(residual_of(turned, baseline_of(turned, keys)),
                               residual_of(motion, baseline_of(motion, keys))),
            2e-4);
}

TEST(Residual, KnowsNoRestFrames) {
  const Poses motion = poses_of(someone());
  std::mt19937_64 random(4);
  std::vector<Quaternionf> rest;
  for (int j = 0; j < kStandardJoints; ++j)
    rest.emplace_back(AngleAxisf(static_cast<float>(uniform(random, -1, 1)),
                                 Vector3f(static_cast<float>(uniform(random, -1, 1)), 1, 0.3F).normalized()));
  Poses other = motion;
  for (int j = 1; j < kStandardJoints; ++j) {
    const auto parent = static_cast<size_t>(standard_parents()[static_cast<size_t>(j)]);
    other.offsets[static_cast<size_t>(j)] = rest[parent].conjugate() * motion.offsets[static_cast<size_t>(j)];
  }
  for (size_t i = 0; i < other.rotations.size(); ++i)
    other.rotations[i] = motion.rotations[i] * rest[i % kStandardJoints];
  for (int64_t t = 0; t < other.frames(); ++t) place_joints(other, t);
  ASSERT_LT(largest_distance(other, motion), 1e-4F) << "the same motion";
  const Tensor keys = whole_keys(kFrames, {0, 60, 120});
  EXPECT_LT(
      largest_difference(residual_of(other, baseline_of(other, keys)), residual_of(motion, baseline_of(motion, keys))),
      2e-4);
}

TEST(Residual, ScaleGrowsWithTheDistanceFromKeys) {
  const Poses motion = poses_of(someone());
  ResidualStatistics statistics;
  const Baseline baseline = baseline_of(motion, whole_keys(kFrames, {0, 60, 90}));
  statistics.add(residual_of(motion, baseline), baseline);
  const Tensor table = statistics.table();
  EXPECT_TRUE((table[0] == 0).all().item<bool>());
  EXPECT_TRUE((table.slice(0, 1).diff(1, 0) >= 0).all().item<bool>());
  EXPECT_TRUE((table.slice(0, 1) > 0).all().item<bool>()) << "of what never moved, too";
  const Tensor scale = residual_scale(baseline, table);
  for (const int64_t t : {0, 60, 90, 100}) EXPECT_EQ(scale.select(1, t).abs().max().item<float>(), 0) << t;
  EXPECT_GT(scale.select(1, 30).min().item<float>(), 0);
}

TEST(Residual, GuardedPointsGoWithJointsAndTheirRotations) {
  const Poses motion = poses_of(someone());
  const Baseline baseline = baseline_of(motion, whole_keys(kFrames, {0, 60, 120}));
  const ResidualFrames frames = residual_frames({&baseline}, torch::ones({kScaleRows, kResidualFeatures}));
  torch::manual_seed(3);
  // Between keys: hands bend beyond what the baseline has of them.
  const Tensor residual = (0.3 * torch::randn({kResidualFeatures, kFrames})) * (frames.scale[0] > 0);
  const Tensor joints = residual_joints(frames, residual.unsqueeze(0));
  const Tensor points = to_world(frames, guarded_points(frames, residual.unsqueeze(0), joints))[0];
  ASSERT_EQ(points.sizes(), torch::IntArrayRef({kFrames, guarded_radii().size(0), 3}));
  const Poses there = motion_of(residual, frames.scale[0], baseline);
  EXPECT_LT(largest_difference(points, guarded_places_of(there)), 1e-4);
}

TEST(Residual, JointsAndGuardedPointsHaveGradients) {
  const Poses motion = poses_of(walker(9, 1.1, 0.7, 1));
  const Baseline baseline = baseline_of(motion, whole_keys(9, {0, 8}));
  const ResidualFrames frames = residual_frames({&baseline}, torch::full({kScaleRows, kResidualFeatures}, 0.3));
  torch::manual_seed(2);
  Tensor residual = torch::randn({1, kResidualFeatures, 9}) * 0.3;
  residual.requires_grad_(true);
  const Tensor weights = torch::randn({1, 9, kStandardJoints, 3}),
               of_points = torch::randn({1, 9, guarded_radii().size(0), 3});
  const auto loss = [&](const Tensor& r) {
    const Tensor joints = residual_joints(frames, r);
    return (to_world(frames, joints) * weights).sum() +
           (to_world(frames, guarded_points(frames, r, joints)) * of_points).sum();
  };
  loss(residual).backward();
  const torch::NoGradGuard no_gradients;
  const Tensor direction = torch::randn_like(residual);
  const float step = 1e-2F;
  const Tensor change = (loss(residual + step * direction) - loss(residual - step * direction)) / (2 * step);
  const auto expected = (residual.grad() * direction).sum().item<float>();
  EXPECT_NEAR(change.item<float>(), expected, 0.01F * std::abs(expected) + 0.02F);
}

}  // namespace
}  // namespace inhabit::inbetween
