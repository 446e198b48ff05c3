#include "inhabit/motion/resample.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "inhabit/error.h"
#include "inhabit/motion/pose_track.h"
#include "refusal_of.h"

using namespace inhabit;

namespace {

// Two joints; the root rotates about +Y at 1 rad/s and is thrown: constant acceleration. Seconds at `rate`.
Clip thrown(double rate, int64_t frames) {
  Clip clip;
  clip.skeleton.names = {"root", "tip"};
  clip.skeleton.parents = {-1, 0};
  clip.skeleton.offsets = torch::tensor({{0.0F, 0.0F, 0.0F}, {1.0F, 0.0F, 0.0F}});
  clip.rate = rate;
  clip.rotations = torch::zeros({frames, 2, 3});
  clip.trans = torch::zeros({frames, 3});
  for (int64_t t = 0; t < frames; ++t) {
    const double s = static_cast<double>(t) / rate;
    clip.rotations[t][0][1] = s;
    clip.trans[t] = torch::tensor({static_cast<float>(2 * s), static_cast<float>(1 + 3 * s - 4.9 * s * s), 0.5F});
  }
  set_pose(clip, pose_track(clip));
  return clip;
}

}  // namespace

TEST(Resample, SteadyRotationsAndThrowsAreExact) {
  for (const double from : {120.0, 50.0, 10.0})
    for (const double to : {30.0, 60.0, 29.97}) {
      const Clip out = resample(thrown(from, static_cast<int64_t>(from) + 1), to);
      const Clip expected = thrown(to, out.frames());
      EXPECT_EQ(out.frames(), static_cast<int64_t>(std::floor(to + 1e-6)) + 1);
      EXPECT_DOUBLE_EQ(out.rate, to);
      EXPECT_TRUE(torch::allclose(out.joints, expected.joints, 0, 1e-5)) << from << " -> " << to;
      EXPECT_TRUE(torch::allclose(out.rotations, expected.rotations, 0, 1e-5));
    }
}

TEST(Resample, EveryFourthFrameIsThatFrame) {
  const Clip clip = thrown(120, 121);
  const Clip out = resample(clip, 30);
  EXPECT_EQ(out.frames(), 31);
  EXPECT_TRUE(torch::allclose(out.joints, clip.joints.slice(0, 0, 121, 4), 0, 1e-6));
}

TEST(Resample, PositionsAloneFollowTheCubic) {
  Clip clip = thrown(30, 31);
  clip.rotations = clip.trans = torch::Tensor();
  const Clip out = resample(clip, 60);
  EXPECT_TRUE(torch::allclose(out.joints.select(1, 0), thrown(60, 61).joints.select(1, 0), 0, 1e-5));
  EXPECT_FALSE(out.rotations.defined());
}

TEST(Resample, JointsKeepTheirDistanceFromThePosedSkeleton) {
  Clip clip = thrown(30, 11);
  clip.joints = clip.joints + 0.01;
  const Clip out = resample(clip, 90);
  EXPECT_TRUE(torch::allclose(out.joints, thrown(90, 31).joints + 0.01, 0, 1e-5));
}

TEST(Resample, RotationsTakeTheShortArc) {
  Clip clip = thrown(1, 2);
  clip.rotations[0][0] = torch::tensor({0.0F, 3.0F, 0.0F});
  clip.rotations[1][0] = torch::tensor({0.0F, -3.0F, 0.0F});  // 0.28 rad further
  const Clip out = resample(clip, 2);
  EXPECT_NEAR(std::abs(out.rotations[1][0][1].item<double>()), M_PI, 1e-3);
}

TEST(Resample, AnnotationsFollow) {
  Clip clip = thrown(10, 11);
  clip.action_names = {"stand", "sit"};
  clip.action = torch::cat({torch::zeros({5}, torch::kLong), torch::ones({6}, torch::kLong)});
  clip.contact = torch::zeros({11, 2});
  clip.contact.slice(0, 5) = 1;
  clip.hand_targets = torch::zeros({11, 2, 4});
  clip.hand_targets.slice(0, 5) = 1;
  clip.object_names = {"chair"};
  clip.object_pose = torch::zeros({11, 1, 6});
  clip.object_pose.select(2, 0) = torch::arange(11).unsqueeze(1);
  clip.object_pose.select(2, 4) = 0.1 * torch::arange(11).unsqueeze(1);
  const Clip out = resample(clip, 40);
  ASSERT_EQ(out.frames(), 41);
  EXPECT_EQ(out.action[17].item<int64_t>(), 0);
  EXPECT_EQ(out.action[18].item<int64_t>(), 1);
  EXPECT_EQ(out.contact[17][1].item<float>(), 0);
  EXPECT_EQ(out.contact[18][1].item<float>(), 1);
  EXPECT_NEAR(out.object_pose[6][0][0].item<double>(), 1.5, 1e-6);
  EXPECT_NEAR(out.object_pose[6][0][4].item<double>(), 0.15, 1e-6);
  // The target is the touched point whenever it is held, never something on the way from nowhere.
  for (int t = 0; t < 41; ++t) {
    const bool held = out.hand_targets[t][0][3].item<float>() > 0.5F;
    EXPECT_EQ(held, t >= 18) << t;
    if (held) {
      EXPECT_EQ(out.hand_targets[t][0][1].item<float>(), 1) << t;
    }
  }
  validate(out, "resampled");
}

TEST(Resample, OneFrameStaysOneFrame) { EXPECT_EQ(resample(thrown(30, 1), 120).frames(), 1); }

TEST(Resample, RefusesAbsurdRates) {
  const Clip clip = thrown(30, 3);
  for (const double rate : {0.0, -30.0, 1e6, std::nan("")}) EXPECT_THROW(resample(clip, rate), Error) << rate;
  Clip empty = clip;
  empty.joints = clip.joints.slice(0, 0, 0);
  EXPECT_THROW(resample(empty, 60), Error);
  Clip slow = clip;  // 55 hours, at ten thousand times its rate
  slow.rotations = slow.trans = torch::Tensor();
  slow.joints = torch::zeros({20000, 2, 3});
  slow.rate = 0.1;
  EXPECT_THAT(refusal_of([&] { return resample(slow, 1000, "slow.bvh"); }),
              testing::HasSubstr("slow.bvh: has too many"));
}
