// Protects where windows of data sets are, and that an evaluation without one is refused.
#include "inhabit/data/window_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "forecast/walker_data.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

TEST(WindowSet, HasTheWindowsOfASplitsClipsInRooms) {
  const TempFolder folder;
  const std::vector<std::string> folders = {write_walkers(folder / "walkers")};
  const WindowSet train(folders, "train", 50, 30, 30, [](const Dataset&) {});
  ASSERT_EQ(train.size(), 3) << "of 120 frames those from 0, 30 and 60 on; the clip without a scene has none";
  EXPECT_EQ(train.entry(2).file, "clips/0.npz");
  EXPECT_EQ(train.place(2).start, 60);
  EXPECT_EQ(WindowSet(folders, "all", 50, 30, 30, [](const Dataset&) {}).spread(3), (std::vector<int64_t>{0, 3, 6}));
  EXPECT_GT(WindowSet(
                folders, "train", 50, 30, 30, [](const Dataset&) {}, false)
                .size(),
            3)
      << "scenes are not asked for";
  EXPECT_EQ(refusal_of([&] { WindowSet(folders, "tran", 50, 30, 30, [](const Dataset&) {}); }),
            "split: 'tran' is none of train, val, test and all");
}

TEST(WindowSet, WindowsOfASetGoByItsFoldersName) {
  const TempFolder folder;
  const std::string a = write_walkers(folder / "a"), b = write_walkers(folder / "b");
  const WindowSet windows({a, b + "/"}, "all", 60, 30, 30, [](const Dataset&) {});
  const auto sets = windows.by_set();
  ASSERT_EQ(sets.size(), 2U);
  EXPECT_EQ(sets[0].first, "a");
  EXPECT_EQ(sets[1].first, "b") << "a slash behind it is none of its name";
  EXPECT_EQ(sets[0].second.size() + sets[1].second.size(), static_cast<size_t>(windows.size()));
  EXPECT_EQ(sets[1].second.front(), static_cast<int64_t>(sets[0].second.size()));
}

TEST(WindowSet, WithoutAWindowCannotBeMeasured) {
  const TempFolder folder;
  const std::vector<std::string> folders = {write_walkers(folder / "walkers")};
  const auto refused = [&](int64_t frames) {
    return refusal_of(
        [&] { require_any_window(WindowSet(folders, "val", frames, 30, 30, [](const Dataset&) {}), folders, "val"); });
  };
  EXPECT_EQ(refused(120), "");
  EXPECT_THAT(refused(121), testing::HasSubstr("walkers: has no window of 121 frames in split val"));
}

TEST(PacedWindow, StaysWithinItsClip) {
  const auto at = [](int64_t start, int64_t clip_frames, double pace) {
    const PacedWindow w = paced_window(start, 61, clip_frames, pace);
    EXPECT_LE(w.first + w.frames, clip_frames);
    EXPECT_LE(60 * w.pace, static_cast<double>(w.frames - 1) + 1e-9);
    return std::pair(w.first, w.pace);
  };
  using testing::Pair;
  EXPECT_THAT(at(10, 200, 1), Pair(10, 1.0));
  EXPECT_THAT(at(10, 200, 1.5), Pair(10, 1.5));
  EXPECT_THAT(at(130, 200, 1.5), Pair(109, 1.5)) << "91 frames end with the clip";
  EXPECT_THAT(at(130, 200, 0.5), Pair(130, 0.5));
  EXPECT_THAT(at(20, 81, 1.5), Pair(0, 80.0 / 60)) << "as fast as a clip of 81 frames lets it";
  EXPECT_THAT(at(0, 61, 2), Pair(0, 1.0));
}

}  // namespace
}  // namespace inhabit
