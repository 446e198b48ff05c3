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

}  // namespace
}  // namespace inhabit
