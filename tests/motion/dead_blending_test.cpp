#include "inhabit/motion/dead_blending.h"

#include <gtest/gtest.h>

#include <cmath>

namespace inhabit {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// One joint that rotates about +Z by `rate` a frame from `angle` on, its root by `step` along +X from `x` on.
PoseTrack turning(int64_t frames, double angle, double rate, double x, double step) {
  PoseTrack out;
  out.joints = 1;
  for (int64_t t = 0; t < frames; ++t) {
    const auto n = static_cast<double>(t);
    out.local.emplace_back(AngleAxisd(angle + n * rate, Vector3d::UnitZ()));
    out.trans.emplace_back(x + n * step, 0, 0);
  }
  return out;
}
double angle_of(const PoseTrack& track, int64_t t) { return 2 * std::atan2(track.at(t, 0).z(), track.at(t, 0).w()); }

// A motion that turns by 0.1 a frame and goes 0.05 m meets one that stands 0.5 and 0.6 m farther on.
struct Meeting {
  PoseTrack track = turning(31, 0.5, 0, 0.6, 0), before = turning(3, -0.3, 0.1, -0.15, 0.05);
  Meeting() {
    track.local[0] = Quaterniond::Identity();
    track.trans[0] = Vector3d::Zero();
  }
};

TEST(DeadBlending, TheFirstFrameGoesOnAsBefore) {
  Meeting m;
  dead_blend(m.track, m.before, 10);
  EXPECT_NEAR(angle_of(m.track, 0), 0, 1e-12) << "the last of the first motion is kept";
  const double faded = 0.0234;  // smoothstep of 1 / 11
  EXPECT_NEAR(angle_of(m.track, 1), 0.1 + faded * (0.5 - 0.1), 1e-4);
  EXPECT_NEAR(m.track.trans[1].x(), 0.05 + faded * (0.6 - 0.05), 1e-4);
}

TEST(DeadBlending, NoStepIsLargeAndTheSecondMotionIsWhatItWasAfterTheFade) {
  Meeting m;
  const PoseTrack raw = m.track;
  dead_blend(m.track, m.before, 10);
  for (int64_t t = 1; t < 31; ++t) {
    const auto i = static_cast<size_t>(t);
    EXPECT_LT(std::abs(angle_of(m.track, t) - angle_of(m.track, t - 1)), 0.11) << t;
    EXPECT_LT((m.track.trans[i] - m.track.trans[i - 1]).norm(), 0.11) << t;
  }
  for (size_t t = 11; t < 31; ++t) {
    EXPECT_EQ(m.track.local[t].coeffs(), raw.local[t].coeffs());
    EXPECT_EQ(m.track.trans[t], raw.trans[t]);
  }
}

TEST(DeadBlending, WhoStandsAndGoesOnStandingStays) {
  PoseTrack track = turning(20, 0.3, 0, 1, 0);
  dead_blend(track, turning(1, 0.3, 0, 1, 0), 8);
  for (int64_t t = 0; t < 20; ++t) EXPECT_NEAR(angle_of(track, t), 0.3, 1e-12);
}

// q and -q are one rotation.
TEST(DeadBlending, RotationsTakeTheShorterArc) {
  Meeting m, other;
  for (Quaterniond& q : other.before.local) q.coeffs() *= -1;
  dead_blend(m.track, m.before, 10);
  dead_blend(other.track, other.before, 10);
  for (int64_t t = 0; t < 31; ++t) EXPECT_NEAR(m.track.at(t, 0).angularDistance(other.track.at(t, 0)), 0, 1e-7);
}

TEST(DeadBlending, MotionsShorterThanTheFadeAreNoError) {
  PoseTrack one = turning(1, 0.3, 0, 1, 0), two = turning(2, 0.3, 0, 1, 0);
  const PoseTrack before = turning(1, 0.3, 0, 1, 0);
  dead_blend(one, before, 10);
  dead_blend(two, before, 10);
  EXPECT_NEAR(angle_of(two, 1), 0.3, 1e-12);
}

}  // namespace
}  // namespace inhabit
