// Protects what a clip may hold: no rate and no place that a wrong unit or a damaged file brings.
#include "inhabit/motion/clip.h"

#include <gtest/gtest.h>

#include <limits>

#include "inhabit/io/files.h"
#include "refusal_of.h"

namespace inhabit {
namespace {

Clip bundled_walk() { return read_clip(std::string(INHABIT_SOURCE_DIR) + "/examples/data/walk.npz"); }

TEST(Clip, RatesThatNoMotionHasAreRefused) {
  Clip clip = bundled_walk();
  for (const double rate : {1e-9, 0.0, -30.0, 1e6, std::numeric_limits<double>::quiet_NaN()}) {
    clip.rate = rate;
    EXPECT_NE(refusal_of([&] { validate(clip, "walk"); }).find("walk: frame rate"), std::string::npos) << rate;
  }
  clip.rate = 0.5;
  EXPECT_EQ(refusal_of([&] { validate(clip, "walk"); }), "");
}

TEST(Clip, JointsBeyondAnyRoomAreRefused) {
  Clip clip = bundled_walk();
  clip.joints = clip.joints + 1e30;
  EXPECT_NE(refusal_of([&] { validate(clip, "walk"); }).find("over 100 km"), std::string::npos);
}

}  // namespace
}  // namespace inhabit
