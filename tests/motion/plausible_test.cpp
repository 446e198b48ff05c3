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
  EXPECT_THAT(implausible(scaled(walk, 0.45)), ElementsAre(HasSubstr("from the ankles over the pelvis to the head")));
  EXPECT_THAT(implausible(scaled(walk, 0.9 / 1.75)), IsEmpty()) << "a child of 0.9 m";
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

TEST(Implausible, IsToldFromOtherNotesAndSaidWithoutOptionsOfStreams) {
  const Clip walk = scaled(walker(60, 1.2), 1000);
  for (const std::string& doubt : implausible(walk, MotionSource::stream)) {
    EXPECT_TRUE(is_doubt("walk.npz: " + doubt));
    EXPECT_THAT(doubt, testing::AllOf(HasSubstr("metres"), testing::Not(HasSubstr("--"))));
  }
  EXPECT_FALSE(is_doubt("walk.npz: lengths taken for metres from the size of the person"));
}

}  // namespace
}  // namespace inhabit
