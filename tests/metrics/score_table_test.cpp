// Protects the one printer of tables: groups, widths, intervals, NaN, and the JSON that goes with it.
#include "inhabit/metrics/score_table.h"

#include <gtest/gtest.h>

#include <cmath>

namespace inhabit {
namespace {

ScoreTable two_rows() {
  ScoreTable table;
  table.labels = {"method"};
  table.columns = {{"Path Error (mm)", "0.5s", "path_error/0.5s", 1},
                   {"Path Error (mm)", "1.0s", "path_error/1.0s", 1},
                   {"", "speed", "speed", 2}};
  table.rows = {{{"last pose held"}, {{1, 0}, {22.26, 0}, {0, 0}}}, {{"ours"}, {{1, 0.5}, {NAN, NAN}, {1.5, 0}}}};
  table.notes = {"2 windows"};
  return table;
}

TEST(ScoreTable, IsAlignedUnderItsTitles) {
  EXPECT_EQ(text_of(two_rows()),
            "               | Path Error (mm)           \n"
            "method         |     0.5s     1.0s    speed\n"
            "last pose held |      1.0     22.3     0.00\n"
            "ours           |      1.0        -     1.50\n"
            "2 windows\n");
}

TEST(ScoreTable, IntervalsFollowMeansThatHaveOne) {
  const std::string text = text_of(two_rows(), true);
  EXPECT_NE(text.find("1.0 +- 0.5"), std::string::npos);
  EXPECT_EQ(text.find("1.50 +-"), std::string::npos);
}

TEST(ScoreTable, JsonNestsByKeyAndKnowsNoNaN) {
  const nlohmann::ordered_json rows = rows_json(two_rows());
  EXPECT_EQ(rows[0]["method"], "last pose held");
  EXPECT_EQ(rows[0]["path_error"]["1.0s"], 22.26);
  EXPECT_TRUE(rows[1]["path_error"]["1.0s"].is_null());
  const nlohmann::ordered_json with = rows_json(two_rows(), true);
  EXPECT_EQ(with[1]["path_error"]["0.5s"]["interval95"], 0.5);
}

}  // namespace
}  // namespace inhabit
