// Protects how measures of data sets are printed: a line each, with what stands out named.
#include <gtest/gtest.h>

#include "inhabit/synth/activity.h"
#include "inhabit/synth/check.h"

namespace inhabit {
namespace {

TEST(Bars, AreALineEach) {
  const std::vector<Bar> bars = {{"foot skating", "of frames", 0, 0.03, 0.0123456, 2, "clips/a.npz", 0.02, ""},
                                 {"depth in walls", "m", -std::numeric_limits<double>::infinity(), 0.02, 0.5, 2,
                                  "clips/b.npz", 0.5, "head in wall_0"},
                                 {"walking speed", "m/s", 0.6, 1.5, 0, 0, "", 0, ""}};
  EXPECT_EQ(
      bars_text(bars),
      "                                          low   measured       high        worst clip\n"
      "foot skating                                0    0.01235       0.03  pass  clips/a.npz (0.02 of frames)\n"
      "depth in walls                           -inf        0.5       0.02  FAIL  clips/b.npz (0.5 m, head in wall_0)\n"
      "walking speed                             0.6          -        1.5  -     no clip has any\n");
  const nlohmann::json json = bars_json(bars);
  ASSERT_EQ(json.size(), 3U);
  EXPECT_EQ(json[1]["where"], "head in wall_0");
  EXPECT_EQ(json[1]["pass"], false);
  EXPECT_EQ(json[2]["clips"], 0);
}

TEST(ActivityTable, LeavesOutWhatNobodyDoes) {
  std::array<ActivityDynamics, kActivityNames.size()> found;
  found[4].raw.frames = 30;
  found[4].raw.speed = 1.25;
  const ScoreTable table = activity_table(found);
  ASSERT_EQ(table.rows.size(), 1U);
  EXPECT_EQ(table.rows[0].labels, std::vector<std::string>{"walking"});
  EXPECT_EQ(table.rows[0].cells.at(1).mean, 1.25);
  EXPECT_EQ(table.columns.size(), table.rows[0].cells.size());
}

}  // namespace
}  // namespace inhabit
