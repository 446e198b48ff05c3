// Protects the evaluation tables: baselines against closed forms, the rows that a model's networks give, the layout.
#include "inhabit/forecast/evaluate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "forecast/walker_data.h"
#include "temp_folder.h"

namespace inhabit::forecast {
namespace {

const Scores* row_of(const Table& table, const std::string& method) {
  for (const Scores& row : table.rows)
    if (row.method == method) return &row;
  return nullptr;
}

TEST(EvaluateForecast, BaselinesOfAPersonAtConstantVelocityAreTheClosedForms) {
  const TempFolder folder;
  Networks none;
  none.config = preset("compact");
  const Data data({write_walkers(folder / "data")}, "all", none.config, 30);
  const Table table = evaluate(none, data);
  EXPECT_EQ(table.windows, 6);
  EXPECT_EQ(table.horizons, (std::vector<double>{0.5, 1.0, 1.5, 2.0}));
  ASSERT_EQ(table.rows.size(), 2U);
  const Scores* held = row_of(table, "last pose held");
  const Scores* moving = row_of(table, "constant velocity");
  ASSERT_TRUE(held != nullptr && moving != nullptr);
  // 1.2 m/s: 600 mm after half a second; the mean over frames 1..60 of 40 mm each.
  const std::vector<double> path = {600, 1200, 1800, 2400, 40 * 30.5};
  for (size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(held->path[i], path[i], 0.05) << i;
    EXPECT_NEAR(moving->path[i], 0, 0.05) << i;
    EXPECT_NEAR(held->pose[i], 0, 0.01) << i;
    EXPECT_NEAR(moving->pose[i], 0, 0.01) << i;
  }
  EXPECT_NEAR(held->seam_path, 40, 0.01);
  EXPECT_NEAR(held->seam_pose, 0, 0.01);
  EXPECT_NEAR(moving->seam_path, 0, 0.01);
  EXPECT_NEAR(held->bones, 0, 0.01);
  EXPECT_NEAR(held->bones_most, 0, 0.01);
  ASSERT_EQ(held->intervals.size(), 13U);
  EXPECT_NEAR(held->intervals[0], 0, 0.05);  // all windows are alike
}

TEST(EvaluateForecast, SeveralDataSetsHaveRowsOfTheirOwnWithIntervals) {
  const TempFolder folder;
  Networks none;
  none.config = preset("compact");
  const Data data({write_walkers(folder / "one"), write_walkers(folder / "two", 30, 1)}, "all", none.config, 30);
  const Table table = evaluate(none, data);
  ASSERT_EQ(table.rows.size(), 6U);
  EXPECT_EQ(table.rows[0].data, "");
  EXPECT_THAT(table.rows[2].data, ::testing::EndsWith("one"));
  EXPECT_THAT(table.rows[4].data, ::testing::EndsWith("two"));
  for (size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(table.rows[0].pose[i], (table.rows[2].pose[i] + table.rows[4].pose[i]) / 2, 1e-6) << i;
  EXPECT_GT(table.rows[0].intervals[5], 0);
  EXPECT_THAT(table_text(table, true), ::testing::HasSubstr("+- 95 % by bootstrap over windows"));
  EXPECT_EQ(table_json(table)["rows"][2]["data"], "one");
}

TEST(EvaluateForecast, EveryNetworkThatIsThereGivesItsRow) {
  const TempFolder folder;
  torch::manual_seed(2);
  Networks model;
  model.config = preset("compact");
  const Data data({write_walkers(folder / "data", 30, 1)}, "test", model.config, 30);
  model.motion = MotionNetwork(model.config);
  model.motion->eval();
  EXPECT_NE(row_of(evaluate(model, data), "w/ true contact"), nullptr);
  EXPECT_EQ(evaluate(model, data).rows.size(), 3U);
  model.contact = ContactNetwork(model.config);
  model.contact->eval();
  model.no_contact = MotionNetwork(model.config, false);
  model.no_contact->eval();
  model.ltd = make_ltd(model.config);
  model.ltd->eval();
  model.hisrep = make_hisrep(model.config);
  model.hisrep->eval();
  model.config.baselines.dmgnn_width = 4;
  model.dmgnn = DmgnnNetwork(model.config);
  model.dmgnn->eval();
  model.slt = SltNetwork(model.config);
  model.slt->eval();

  const Table table = evaluate(model, data);
  std::vector<std::string> methods;
  for (const Scores& row : table.rows) {
    methods.push_back(row.method);
    EXPECT_EQ(row.path.size(), 5U);
    for (const double v : row.path) EXPECT_GT(v, 0) << row.method;
    for (const double v : row.pose) EXPECT_GT(v, 0) << row.method;
  }
  EXPECT_EQ(methods, (std::vector<std::string>{"last pose held", "constant velocity", "LTD", "HisRep", "DMGNN", "SLT*",
                                               "w/o contact", "predicted contact", "w/ true of feet",
                                               "w/ true of others", "w/ true contact"}));
  const std::string text = table_text(table);
  for (const std::string& method : methods) EXPECT_THAT(text, ::testing::HasSubstr(method));
  EXPECT_THAT(text, ::testing::HasSubstr("Path Error (mm)"));
  const nlohmann::json json = table_json(table);
  EXPECT_EQ(json["rows"].size(), 11U);
  EXPECT_EQ(json["rows"][0]["path_error"]["2.0s"], table.rows[0].path[3]);
  EXPECT_EQ(json["rows"][10]["pose_error"]["mean"], table.rows[10].pose[4]);
}

}  // namespace
}  // namespace inhabit::forecast
