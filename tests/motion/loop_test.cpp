// Protects loops: the last pose is the first where the last stands, and what follows on it is what follows on the
// first.
#include "inhabit/motion/loop.h"

#include <gtest/gtest.h>

#include "forecast/walker.h"
#include "inhabit/motion/canonical.h"
#include "refusal_of.h"

namespace inhabit {
namespace {

TEST(Loop, GoesOnWhereItEnds) {
  const Clip walk = walker(100, 1.3, 0.7, 1), loop = looped(walk, 0.5, "walk");
  ASSERT_EQ(loop.frames(), 100 - 15 + 1);
  EXPECT_TRUE(torch::equal(loop.joints.slice(0, 15), walk.joints.slice(0, 15, 86))) << "the rest stays as it is";
  // The next round, moved to where this one ends.
  const GroundTransform there = canonical_transform(loop, 85).inverse();
  const Clip next = transformed(transformed(loop, canonical_transform(loop, 0)), there);
  EXPECT_LT((next.joints[0] - loop.joints[85]).norm(2, 1).max().item<double>(), 1e-4);
  const torch::Tensor before = loop.joints[85] - loop.joints[84], after = next.joints[1] - next.joints[0];
  const torch::Tensor steps = walk.joints.slice(0, 1) - walk.joints.slice(0, 0, -1);
  const auto change = (steps.slice(0, 1) - steps.slice(0, 0, -1)).norm(2, 2).max().item<double>();
  EXPECT_LT((after - before).norm(2, 1).max().item<double>(), 1.1 * change)
      << "no more than limbs do when they swing back";
  EXPECT_NEAR((loop.root_path()[85] - loop.root_path()[0]).norm().item<double>(), 1.3 * 85 / 30, 1e-3) << "and goes on";
}

TEST(Loop, OfJointsAloneAndOfFewFrames) {
  Clip walk = walker(100, 1.3, 0, 1);
  walk.rotations = walk.trans = torch::Tensor();
  const Clip loop = looped(walk, 0.5, "walk");
  EXPECT_LT((loop.joints[85].select(1, 1) - loop.joints[0].select(1, 1)).abs().max().item<double>(), 1e-4);
  EXPECT_EQ(looped(slice(walk, 0, 6), 0.5, "walk").frames(), 6 - 2 + 1);
  EXPECT_EQ(refusal_of([&] { looped(slice(walk, 0, 3), 0.5, "a.bvh"); }),
            "a.bvh: has 3 frames: four are needed for a loop");
}

}  // namespace
}  // namespace inhabit
