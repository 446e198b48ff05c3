// Protects what in-betweening sees of a clip: nothing is lost on the way to features and back, bones are the person's
// own, noise is of the level asked for and spares the ends.
#include "inhabit/inbetween/features.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "forecast/walker.h"
#include "inhabit/math/rotation.h"
#include "largest.h"
#include "refusal_of.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

TEST(InbetweenFeatures, ComeBackAsTheSameMotion) {
  const Clip clip = walker(20, 1.1, 0.7, 1, 0.4, -2);
  const Tensor features = clip_features(clip);
  ASSERT_EQ(features.sizes(), (torch::IntArrayRef{20, kFeatureCount}));
  EXPECT_EQ(largest_difference(features.slice(1, 0, 3), clip.root_path()), 0);
  EXPECT_EQ(largest_difference(features.slice(1, kJointFeature).view({20, 22, 3}), clip.joints), 0);
  EXPECT_LT(largest_difference(feature_joints(features, clip.skeleton.offsets), clip.joints), 1e-5);
  const Clip back = clip_of_features(features, clip);
  EXPECT_LT(largest_difference(back.joints, clip.joints), 1e-5);
  EXPECT_LT(largest_difference(back.trans, clip.trans), 1e-6);
  EXPECT_LT(largest_difference(axis_angle_to_matrix(back.rotations), axis_angle_to_matrix(clip.rotations)), 1e-5);
}

TEST(InbetweenFeatures, BonesMayDifferInABatch) {
  const Clip clip = walker(4, 1, 0, 1);
  const Tensor features = clip_features(clip), bones = clip.skeleton.offsets;
  const Tensor both = feature_joints(torch::stack({features, features}), torch::stack({bones, 2 * bones}));
  EXPECT_LT(largest_difference(both[0], clip.joints), 1e-5);
  // Twice as tall about the same root.
  const Tensor root = clip.root_path().unsqueeze(1);
  EXPECT_LT(largest_difference(both[1] - root, 2 * (clip.joints - root)), 1e-5);
}

TEST(InbetweenFeatures, NeedRotationsOnTheStandardSkeleton) {
  Clip clip = walker(4, 1);
  clip.rotations = Tensor();
  EXPECT_THAT(refusal_of([&] { clip_features(clip); }), ::testing::HasSubstr("rotations"));
}

TEST(NoisyFeatures, AreOfTheLevelAskedForAndSpareTheEnds) {
  const Clip clip = walker(400, 1, 0.3, 1);
  const Tensor clean = clip_features(clip);
  std::mt19937_64 random(3);
  const Tensor noisy = noisy_features(clean, clip.skeleton.offsets, 1, random);
  EXPECT_TRUE(torch::equal(noisy[0], clean[0]));
  EXPECT_TRUE(torch::equal(noisy[399], clean[399]));
  const Tensor moved = (noisy - clean).slice(0, 1, 399).slice(1, 0, 3);
  EXPECT_NEAR(moved.std().item<double>(), 0.01, 0.001) << "a centimetre";
  const Tensor angles =
      matrix_to_axis_angle(feature_rotations(clean).transpose(-1, -2).matmul(feature_rotations(noisy)));
  EXPECT_NEAR(angles.slice(0, 1, 399).std().item<double>(), M_PI / 180, 0.001) << "a degree";
  EXPECT_LT(largest_difference(feature_joints(noisy, clip.skeleton.offsets),
                               noisy.slice(1, kJointFeature).view({400, 22, 3})),
            1e-5);
  EXPECT_TRUE(torch::equal(noisy_features(clean, clip.skeleton.offsets, 0, random), clean));
}

TEST(BodyShapeFeatures, FollowStatureAndGirth) {
  const BodyModel& body = builtin_body();
  const Tensor mean = body_shape_features(body, {});
  ASSERT_EQ(mean.size(0), kShapeFeatures);
  EXPECT_GT(mean.min().item<double>(), 0.1);
  EXPECT_LT(mean.max().item<double>(), 1.1);
  Tensor betas = torch::zeros({body.betas()});
  betas[0] = 2;  // stature, 4 % a unit
  EXPECT_LT(largest_difference(body_shape_features(body, betas) / mean, torch::full({7}, 1.08)), 0.01);
  betas.zero_();
  betas[4] = 2;  // girth: thicker, but no longer
  const Tensor stout = body_shape_features(body, betas);
  EXPECT_LT(largest_difference(stout.slice(0, 0, 5), mean.slice(0, 0, 5)), 1e-5);
  EXPECT_GT((stout - mean).slice(0, 5).min().item<double>(), 0.01);
}

TEST(InbetweenFeatures, TurnedRestFramesLeaveTheMotionAsItIs) {
  torch::manual_seed(6);
  const Clip clip = walker(9, 1, 0.3, 1);
  const Tensor features = clip_features(clip);
  Tensor bones = clip.skeleton.offsets;
  const Tensor rotations = axis_angle_to_matrix(torch::randn({kStandardJoints, 3}) * 0.2);
  const Tensor rotated = with_rest_frames_rotated(features, rotations, bones);
  EXPECT_LT(
      (feature_joints(rotated, bones) - feature_joints(features, clip.skeleton.offsets)).abs().max().item<double>(),
      1e-4);
  EXPECT_GT((feature_rotations(rotated) - feature_rotations(features)).abs().max().item<double>(), 0.1);
  EXPECT_TRUE(torch::equal(rotated.slice(1, kJointFeature), features.slice(1, kJointFeature)));
  // A joint's own frame is rotated, not that of its parent's rest: the root's first.
  EXPECT_TRUE(torch::allclose(feature_rotations(rotated).select(1, 0),
                              torch::matmul(feature_rotations(features).select(1, 0), rotations[0]), 1e-4, 1e-5));
}

/// Features (1, 201, T) whose left knee is bent by `degrees` (T) and nothing else rotated; standardised by mean 0.1 and
/// deviation 0.3.
Tensor knee_bent(const Tensor& degrees) {
  Tensor rotations = torch::zeros({degrees.size(0), kStandardJoints, 3});
  rotations.select(1, 4).select(1, 0).copy_(degrees * (M_PI / 180));
  Tensor features = torch::zeros({1, kFeatureCount, degrees.size(0)});
  features[0]
      .slice(0, kOrientFeature, kJointFeature)
      .copy_(matrix_to_rotation6d(axis_angle_to_matrix(rotations)).flatten(1).t());
  return (features - 0.1) / 0.3;
}

/// How far the left knee of such features is bent: (T) degrees.
Tensor knee_bend(const Tensor& features) {
  const Tensor rotations = matrix_to_axis_angle(feature_rotations(features[0].t() * 0.3 + 0.1));
  return rotations.select(1, 4).select(1, 0) * (180 / M_PI);
}

const Tensor kMean = torch::full({kFeatureCount}, 0.1), kDeviation = torch::full({kFeatureCount}, 0.3);

TEST(GivenPoses, RotateEvenlyBetweenKeysFarApart) {
  KeyConstraints given{knee_bent(torch::linspace(0, 170, 11)), torch::zeros({1, kFeatureCount, 11})};
  for (const int64_t key : {0, 10}) given.mask.select(2, key).fill_(1);
  const Tensor between = interpolated_baseline(given, {kMean, kDeviation});
  EXPECT_LT(largest_difference(knee_bend(between), torch::linspace(0, 170, 11)), 0.1);
  EXPECT_LT(
      largest_difference(between.slice(1, 0, kOrientFeature), interpolate_keys(given).slice(1, 0, kOrientFeature)),
      1e-6);
}

}  // namespace
}  // namespace inhabit::inbetween
