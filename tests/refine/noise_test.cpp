// Protects the levels of noise and jerk that refinement is weighted by: noise is found beside motion of any size, clean
// motion has none, and livelier motion is told from calm.
#include "inhabit/refine/noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;

constexpr double kSampled = 30;

/// Third differences of places of amplitude `metres` at `hertz`, with white noise on each component.
Track thirds(int frames, double metres, double hertz, double noise) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0, 1);
  Track track, out;
  for (int t = 0; t < frames; ++t) {
    const double phase = 2 * M_PI * hertz * t / kSampled;
    track.push_back(metres * Vector3d(std::sin(phase), std::cos(phase), std::sin(phase + 1)) +
                    noise * Vector3d(normal(random), normal(random), normal(random)));
  }
  for (size_t t = 0; t + 3 < track.size(); ++t)
    out.push_back(track[t + 3] - 3 * track[t + 2] + 3 * track[t + 1] - track[t]);
  return out;
}

TEST(Noise, IsToldFromMotion) {
  for (const double noise : {0.002, 0.01}) {
    for (const double metres : {0.0, 0.1, 0.3})
      EXPECT_NEAR(level_of(thirds(240, metres, 1.5, noise), kSampled).noise, noise, 0.15 * noise) << metres;
    EXPECT_NEAR(level_of(thirds(900, 0.3, 1.5, noise), kSampled).noise, noise, 0.07 * noise) << "in several pieces";
  }
}

TEST(Noise, CleanMotionHasNone) { EXPECT_LT(level_of(thirds(240, 0.3, 1.5, 0), kSampled).noise, 1e-4); }

TEST(Noise, LivelierMotionHasMoreJerk) {
  const auto jerk = [](double metres, double hertz) {
    return level_of(thirds(240, metres, hertz, 0.01), kSampled).jerk;
  };
  EXPECT_GT(jerk(0.2, 2), 2 * jerk(0.2, 0.5));
  EXPECT_GT(jerk(0.4, 2), jerk(0.1, 2));
}

TEST(Noise, ShortMotionsTellNothing) {
  EXPECT_EQ(level_of({}, kSampled).noise, 0);
  EXPECT_EQ(level_of({Vector3d::Ones()}, kSampled).jerk, 0);
}

}  // namespace
}  // namespace inhabit::refine
