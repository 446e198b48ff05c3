// Protects the keys that training windows are given: the paper's counts and keys far apart, open ends, known
// beginnings, partial keys.
#include "inhabit/inbetween/drawn_keys.h"

#include <gtest/gtest.h>

#include <set>

#include "inhabit/inbetween/keyframes.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

constexpr int64_t kFrames = 121, kWindows = 2000;

TEST(DrawnKeys, BeginWithAWholePoseAndMostlyEndWithOne) {
  std::mt19937_64 random(1);
  int open = 0, known = 0, partial = 0;
  for (int64_t i = 0; i < kWindows; ++i) {
    const DrawnKeys keys = draw_keys(kFrames, true, 0.5, random);
    ASSERT_TRUE((keys.groups[0] == 1).all().item<bool>());
    const Tensor given = keys.groups.sum(1), whole = given == kKeyGroups;
    const auto last = given.nonzero().max().item<int64_t>();
    ASSERT_TRUE(whole[last].item<bool>()) << "the last key is a whole pose";
    EXPECT_EQ(keys.ends[last].item<float>(), 1);
    open += last < kFrames - 1 ? 1 : 0;
    known += keys.ends.sum().item<int64_t>() > 2 ? 1 : 0;
    partial += ((given > 0) & ~whole).any().item<bool>() ? 1 : 0;
  }
  EXPECT_NEAR(open, 0.25 * kWindows, 0.04 * kWindows);
  EXPECT_NEAR(known, 0.3 * kWindows, 0.04 * kWindows);
  EXPECT_GT(partial, 0.1 * kWindows);
  EXPECT_LT(partial, 0.31 * kWindows);
}

TEST(DrawnKeys, PartialOnesConstrainTheSameJointsAllOverAWindow) {
  std::mt19937_64 random(2);
  for (int64_t i = 0; i < 200; ++i) {
    const DrawnKeys keys = draw_keys(kFrames, true, 0, random);
    std::set<std::vector<float>> kinds;
    for (int64_t t = 0; t < kFrames; ++t) {
      const Tensor row = keys.groups[t].contiguous();
      if (row.sum().item<float>() > 0 && row.sum().item<float>() < kKeyGroups)
        kinds.emplace(row.data_ptr<float>(), row.data_ptr<float>() + kKeyGroups);
    }
    EXPECT_LE(kinds.size(), 1U);
    for (const auto& kind : kinds)
      EXPECT_EQ(kind[kRootTranslationGroup], kind[kJointGroups]) << "the pelvis and the root are one point";
  }
}

TEST(DrawnKeys, FarOnesAreEquallyApart) {
  std::mt19937_64 random(3);
  for (int64_t i = 0; i < 200; ++i) {
    const DrawnKeys keys = draw_keys(kFrames, false, 1, random);
    const Tensor frames = (keys.groups.sum(1) > 0).nonzero().view({-1});
    const Tensor apart = frames.diff();
    const auto wide = apart.masked_select(apart > 1);  // known beginnings are side by side
    if (wide.size(0) < 3) continue;
    const Tensor inner = wide.slice(0, 1, -1);  // the first is cut by what is known, the last by the end
    EXPECT_EQ(inner.min().item<int64_t>(), inner.max().item<int64_t>());
    EXPECT_GE(inner.min().item<int64_t>(), 30);
    EXPECT_LE(inner.max().item<int64_t>(), 120);
  }
}

}  // namespace
}  // namespace inhabit::inbetween
