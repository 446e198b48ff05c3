// Protects what a forecasting system observes of files of any rate: a second is a second of the file.
#include "inhabit/motion/observe.h"

#include <gtest/gtest.h>

#include "forecast/walker.h"
#include "inhabit/motion/resample.h"
#include "refusal_of.h"

namespace inhabit {
namespace {

TEST(Observe, FifteenFramesAtFifteenHertzAreOneSecond) {
  const Clip walk = walker(60, 1.2), slow = slice(resample(walk, 15), 0, 15);
  const Observed observed = observe(slow, -1, 30, 30, "slow.bvh");
  EXPECT_EQ(observed.start, 30);
  ASSERT_EQ(observed.motion.frames(), 30);
  // From frame 28 of the walk back to the one before its first.
  EXPECT_LT((observed.motion.joints.slice(0, 1) - walk.joints.slice(0, 0, 29)).norm(2, 2).max().item<double>(), 0.02);
  const torch::Tensor root = observed.motion.root_path();
  EXPECT_LT((root[0] - (2 * root[1] - root[2])).norm().item<double>(), 1e-5);
  EXPECT_TRUE(torch::isfinite(observed.motion.rotations).all().item<bool>());
  for (const double rate : {10.0, 12.0, 24.0, 25.0}) {
    const auto second = static_cast<int64_t>(rate);
    EXPECT_EQ(observe(slice(resample(walk, rate), 0, second), -1, 30, 30, "a").start, 30) << rate;
    EXPECT_EQ(refusal_of([&] { observe(slice(resample(walk, rate), 0, second - 1), -1, 30, 30, "a.bvh"); }),
              "a.bvh: has " + std::to_string(second - 1) + " frames at " + std::to_string(second) +
                  " a second before the start; at least " + std::to_string(second) + " are needed");
  }
}

TEST(Observe, AStartUnderZeroIsTheEndOrRefused) {
  const Clip walk = walker(60, 1.2);
  EXPECT_EQ(observe(walk, -1, 30, 30, "walk").start, 60);
  EXPECT_EQ(refusal_of([&] { observe(walk, -2, 30, 30, "walk"); }), "start: is under 0");
}

TEST(Observe, EnoughFramesAreTakenAsTheyAre) {
  const Clip walk = walker(60, 1.2);
  const Observed observed = observe(walk, 45, 30, 30, "walk");
  EXPECT_EQ(observed.start, 45);
  EXPECT_TRUE(observed.motion.joints.allclose(walk.joints, 0, 1e-5));
}

}  // namespace
}  // namespace inhabit
