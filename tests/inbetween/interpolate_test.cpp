// Protects the baselines of in-betweening: keys are met, what is between follows from the keys alone and is what the
// formulas give.
#include "inhabit/inbetween/interpolate.h"

#include <gmock/gmock.h>

#include <random>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/math/random.h"
#include "refusal_of.h"

namespace inhabit::inbetween {
namespace {

using testing::HasSubstr;

Clip still(int64_t frames) {
  Clip clip;
  clip.skeleton = shaped_skeleton(builtin_body(), {});
  clip.rotations = torch::zeros({frames, kStandardJoints, 3});
  clip.trans = torch::zeros({frames, 3});
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

// Every frame another pose, drawn from a seed, with rotations of up to two radians about each axis.
Clip restless(int64_t frames, uint64_t seed) {
  std::mt19937_64 random(seed);
  Clip clip = still(frames);
  for (torch::Tensor* part : {&clip.rotations, &clip.trans}) {
    float* values = part->data_ptr<float>();
    for (int64_t i = 0; i < part->numel(); ++i) values[i] = static_cast<float>(uniform(random, -1.1, 1.1));
  }
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

using Interpolate = Clip (*)(const Clip&, const std::vector<int64_t>&);

class Baselines : public testing::TestWithParam<Interpolate> {};

TEST_P(Baselines, MeetTheKeysAndAskNothingElse) {
  const Clip clip = restless(41, 7);
  const std::vector<int64_t> keys = {0, 3, 4, 20, 40};
  const Clip filled = GetParam()(clip, keys);
  for (const int64_t t : keys) {
    EXPECT_TRUE(filled.trans[t].allclose(clip.trans[t], 1e-6, 1e-6)) << t;
    EXPECT_TRUE(filled.rotations[t].allclose(clip.rotations[t], 1e-5, 1e-5)) << t;
    EXPECT_TRUE(filled.joints[t].allclose(clip.joints[t], 1e-4, 1e-4)) << t;
  }
  EXPECT_TRUE(filled.joints.allclose(joint_positions(clip.skeleton, filled.rotations, filled.trans), 1e-4, 1e-4));
  EXPECT_TRUE(filled.rotations.isfinite().all().item<bool>());
  // What lies between the keys does not show in the result.
  Clip other = restless(41, 8);
  for (const int64_t t : keys) {
    other.trans[t] = clip.trans[t];
    other.rotations[t] = clip.rotations[t];
  }
  EXPECT_TRUE(GetParam()(other, keys).joints.equal(filled.joints));
  EXPECT_GT((filled.joints - clip.joints).norm(2, {2}).max().item<double>(), 0.1);
}

TEST_P(Baselines, GoStraightBetweenTwoKeys) {
  Clip clip = still(11);
  clip.trans[10] = torch::tensor({1.F, 0.5F, -2.F});
  clip.rotations[0][0][1] = 0.4F;
  clip.rotations[10][0][1] = 1.4F;  // a rotation by one radian about the vertical
  const Clip filled = GetParam()(clip, {0, 10});
  EXPECT_TRUE(filled.trans[5].allclose(torch::tensor({0.5F, 0.25F, -1.F}), 1e-5, 1e-6));
  EXPECT_TRUE(filled.trans[3].allclose(torch::tensor({0.3F, 0.15F, -0.6F}), 1e-5, 1e-6));
  EXPECT_TRUE(filled.rotations[5][0].allclose(torch::tensor({0.F, 0.9F, 0.F}), 1e-5, 1e-5));
}

TEST_P(Baselines, RotateAlongTheShortArc) {
  Clip clip = still(5);
  clip.rotations[0][16][0] = 3.0F;   // 172 degrees
  clip.rotations[4][16][0] = -3.0F;  // 16 degrees further on
  const Clip filled = GetParam()(clip, {0, 4});
  EXPECT_NEAR(std::abs(filled.rotations[2][16][0].item<float>()), M_PI, 1e-4);
}

TEST_P(Baselines, RefuseWhatIsNoKeyFrames) {
  const Clip clip = still(11);
  const auto refused = [&](const std::vector<int64_t>& keys) { return refusal_of([&] { GetParam()(clip, keys); }); };
  EXPECT_THAT(refused({}), HasSubstr("fewer than two"));
  EXPECT_THAT(refused({0}), HasSubstr("fewer than two"));
  EXPECT_THAT(refused({0, 5, 5, 10}), HasSubstr("not in order"));
  EXPECT_THAT(refused({0, 5}), HasSubstr("first frame to its last"));
  EXPECT_THAT(refused({-1, 5, 10}), HasSubstr("first frame to its last"));
  EXPECT_THAT(refused({0, 11}), HasSubstr("first frame to its last"));
  Clip positions = clip;
  positions.rotations = torch::Tensor();
  EXPECT_THAT(refusal_of([&] { GetParam()(positions, {0, 10}); }), HasSubstr("no rotations"));
}

INSTANTIATE_TEST_SUITE_P(Both, Baselines, testing::Values(&interpolate_linear, &interpolate_spline),
                         [](const auto& which) { return which.index == 0 ? "Linear" : "Spline"; });

TEST(InterpolateLinear, RotatesEvenly) {
  Clip clip = still(7);
  clip.rotations[6][18][2] = 1.8F;
  const Clip filled = interpolate_linear(clip, {0, 6});
  for (int64_t t = 0; t < 7; ++t)
    EXPECT_NEAR(filled.rotations[t][18][2].item<float>(), 0.3F * static_cast<float>(t), 1e-5);
}

TEST(InterpolateSpline, IsTheNaturalCubic) {
  // Through (0, 0), (10, 1), (20, 0): curvature 0 at the ends and -0.03 in the middle, so that at a quarter the value
  // is 0.5 + 100 / 6 * (0.125 - 0.5) * -0.03 = 0.6875.
  Clip clip = still(21);
  clip.trans[10][0] = 1;
  const Clip filled = interpolate_spline(clip, {0, 10, 20});
  EXPECT_NEAR(filled.trans[5][0].item<float>(), 0.6875, 1e-6);
  EXPECT_NEAR(filled.trans[15][0].item<float>(), 0.6875, 1e-6);
  // Uneven keys: through (0, 0), (4, 1), (12, 0): 24 m = 6 (-1/8 - 1/4), m = -3/32. Frame 2: 0.5 + 16/6 * (-3/8) m;
  // frame 8: 0.5 + 64/6 * (-3/8) m.
  Clip uneven = still(13);
  uneven.trans[4][2] = 1;
  const Clip through = interpolate_spline(uneven, {0, 4, 12});
  EXPECT_NEAR(through.trans[2][2].item<float>(), 0.5 + 16. / 6 * 3 / 8 * 3 / 32, 1e-6);
  EXPECT_NEAR(through.trans[8][2].item<float>(), 0.5 + 64. / 6 * 3 / 8 * 3 / 32, 1e-6);
}

TEST(InterpolateSpline, HasNoKinkAtKeysWhereTheLinearOneHas) {
  const Clip clip = restless(61, 3);
  const std::vector<int64_t> keys = key_frames("every:20", 61);
  const auto kink = [](const Clip& filled) {  // largest second difference of the root, at the keys inside
    const torch::Tensor d = torch::diff(filled.trans, 2, 0).norm(2, {1});
    return std::max(d[19].item<double>(), d[39].item<double>());
  };
  EXPECT_LT(kink(interpolate_spline(clip, keys)), 0.25 * kink(interpolate_linear(clip, keys)));
}

}  // namespace
}  // namespace inhabit::inbetween
