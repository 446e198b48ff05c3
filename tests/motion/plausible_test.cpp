// Protects the doubts about motion that cannot be a person's as it was read, and that there are none about motion that
// can.
#include "inhabit/motion/plausible.h"

#include <gmock/gmock.h>

#include "forecast/walker.h"
#include "inhabit/motion/level.h"

namespace inhabit {
namespace {

using testing::ElementsAre, testing::HasSubstr, testing::IsEmpty;

Clip scaled(Clip clip, double scale) {
  clip.joints = clip.joints * scale;
  return clip;
}

TEST(Implausible, SizeAxisAndSpeedAreDoubted) {
  const Clip walk = walker(60, 1.2);
  EXPECT_THAT(implausible(walk), IsEmpty());
  EXPECT_THAT(implausible(scaled(walk, 100)), ElementsAre(HasSubstr("legs are"), HasSubstr("moves at")));
  EXPECT_THAT(implausible(scaled(walk, 0.1)), ElementsAre(HasSubstr("--scale")));
  Clip lying = walk;
  rotate_clip(lying, torch::tensor({{1.F, 0.F, 0.F}, {0.F, 0.F, -1.F}, {0.F, 1.F, 0.F}}));
  EXPECT_THAT(implausible(lying), ElementsAre(HasSubstr("lies throughout; --up")));
  Clip head_down = walk;
  rotate_clip(head_down, torch::tensor({{1.F, 0.F, 0.F}, {0.F, -1.F, 0.F}, {0.F, 0.F, -1.F}}));
  EXPECT_THAT(implausible(head_down), ElementsAre(HasSubstr("stands on their head")));
  Clip fast = walk;
  fast.rate = 600;
  EXPECT_THAT(implausible(fast), ElementsAre(HasSubstr("moves at 24 m/s; --scale and --input-rate")));
}

}  // namespace
}  // namespace inhabit
