#include "inhabit/motion/inertialize.h"

#include <gtest/gtest.h>

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

// A motion that turns by 0.1 a frame meets one that stands 0.5 farther on.
struct Meeting {
  PoseTrack track = turning(31, 0.5, 0, 2, 0), before = turning(1, -0.1, 0, -0.05, 0);
  Meeting() {
    track.local[0] = Quaterniond::Identity();
    track.trans[0] = Vector3d::Zero();
  }
};

TEST(Inertialize, TheFirstFrameGoesOnAsBefore) {
  Meeting m;
  inertialize(m.track, m.before, 10);
  EXPECT_NEAR(angle_of(m.track, 0), 0, 1e-12) << "the last of the first motion is kept";
  EXPECT_NEAR(angle_of(m.track, 1), 0.1, 1e-9);
  EXPECT_NEAR(m.track.trans[1].x(), 0.05, 1e-12);
}

TEST(Inertialize, TheDifferenceFadesOutWithoutAJumpAndIsGoneAtItsEnd) {
  Meeting m;
  const PoseTrack raw = m.track;
  inertialize(m.track, m.before, 10);
  for (int64_t t = 2; t < 31; ++t) {
    // From 0.1 to 0.5 within 10 frames: a smoothstep's steepest step is 1.5 times its mean.
    EXPECT_LT(std::abs(angle_of(m.track, t) - angle_of(m.track, t - 1)), 0.4 / 10 * 1.51);
    EXPECT_LT((m.track.trans[static_cast<size_t>(t)] - m.track.trans[static_cast<size_t>(t) - 1]).norm(),
              1.95 / 10 * 1.51);
  }
  for (size_t t = 11; t < 31; ++t) {
    EXPECT_EQ(m.track.local[t].coeffs(), raw.local[t].coeffs());
    EXPECT_EQ(m.track.trans[t], raw.trans[t]);
  }
}

TEST(Inertialize, WhatMeetsWithoutAJumpStays) {
  PoseTrack track = turning(20, 0.3, 0.02, 1, 0.01);
  const PoseTrack raw = track, before = turning(1, 0.28, 0, 0.99, 0);
  inertialize(track, before, 8);
  for (int64_t t = 0; t < 20; ++t) EXPECT_NEAR(angle_of(track, t), angle_of(raw, t), 1e-9);
}

TEST(Inertialize, ShortMotionsAreNoError) {
  PoseTrack one = turning(1, 0.3, 0, 1, 0), two = turning(2, 0.3, 0, 1, 0);
  inertialize(one, one, 10);
  const PoseTrack before = turning(1, 0.3, 0, 1, 0);
  inertialize(two, before, 10);
  EXPECT_NEAR(angle_of(two, 1), 0.3, 1e-12);
}

}  // namespace
}  // namespace inhabit
