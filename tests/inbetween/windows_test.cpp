// Protects how long clips are cut: every frame is filled once the windows are done, each window fits the network and
// ends at a key frame, and each goes on from what stands.
#include "inhabit/inbetween/windows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "refusal_of.h"

namespace inhabit::inbetween {
namespace {

std::vector<int64_t> every(int64_t n, int64_t frames) {
  std::vector<int64_t> out;
  for (int64_t f = 0; f < frames; f += n) out.push_back(f);
  if (out.back() != frames - 1) out.push_back(frames - 1);
  return out;
}

TEST(FillWindows, AClipOfOneWindowIsFilledAtOnce) {
  const auto windows = fill_windows({0, 60, 120}, 121, 60, 8, 0);
  ASSERT_EQ(windows.size(), 1U);
  EXPECT_EQ(windows[0].first, 0);
  EXPECT_EQ(windows[0].last, 120);
  EXPECT_EQ(windows[0].known, 0);
  EXPECT_EQ(fill_windows({0, 20}, 121, 60, 8, 0).size(), 1U) << "shorter than a window";
}

TEST(FillWindows, EachGoesOnFromSixtyFramesOfTheOneBefore) {
  const auto windows = fill_windows(every(15, 301), 121, 60, 8, 0);
  ASSERT_EQ(windows.size(), 4U);
  for (size_t i = 1; i < windows.size(); ++i) {
    EXPECT_EQ(windows[i].known, windows[i - 1].last);
    EXPECT_EQ(windows[i].known - windows[i].first + 1, 60);
  }
  EXPECT_EQ(windows.back().last, 300);
}

TEST(FillWindows, CoverAnyClipWhoseKeysAreNearEnough) {
  std::mt19937_64 random(3);
  for (int round = 0; round < 200; ++round) {
    std::vector<int64_t> keys = {0};
    while (keys.size() < 12) keys.push_back(keys.back() + 1 + static_cast<int64_t>(random() % 100));
    const int64_t redone = round % 2 == 0 ? 0 : 8;
    int64_t filled = 0;
    for (const FillWindow& w : fill_windows(keys, 121, 60, 8, redone)) {
      EXPECT_LE(w.last - w.first + 1, 121);
      EXPECT_TRUE(std::find(keys.begin(), keys.end(), w.last) != keys.end()) << w.last;
      EXPECT_LE(w.first, w.known);
      EXPECT_LE(w.known, filled) << "frames that stand were filled before";
      EXPECT_GE(w.known, filled - redone);
      EXPECT_GT(w.last, filled) << "goes on";
      EXPECT_GE(w.known - w.first + 1, std::min<int64_t>(8, w.known + 1)) << "enough to go on from";
      filled = w.last;
    }
    EXPECT_EQ(filled, keys.back());
  }
}

TEST(FillWindows, RefuseKeysOutOfReach) {
  EXPECT_EQ(fill_windows({0, 120}, 121, 60, 8, 0).size(), 1U);
  EXPECT_THAT(refusal_of([] { fill_windows({0, 121}, 121, 60, 8, 0); }), ::testing::HasSubstr("0 and 121"));
  EXPECT_THAT(refusal_of([] { fill_windows({0, 60, 175}, 121, 60, 8, 0); }), ::testing::HasSubstr("115 frames apart"));
  // Of a file of 120 frames a second.
  EXPECT_THAT(refusal_of([] {
                fill_windows({0, 60, 175}, 121, 60, 8, 0, 4);
              }),
              ::testing::HasSubstr("240 and 700 are 460 frames apart; at most 452"));
  EXPECT_EQ(fill_windows({0, 60, 173}, 121, 60, 8, 0).back().last, 173);
  EXPECT_THAT(refusal_of([] { fill_windows({0, 60, 170}, 121, 60, 8, 8); }), ::testing::HasSubstr("at most 105"));
  EXPECT_EQ(fill_windows({0, 60, 165}, 121, 60, 8, 8).back().last, 165);
}

}  // namespace
}  // namespace inhabit::inbetween
