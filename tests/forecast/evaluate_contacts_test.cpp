// Protects the diagnosis of contacts: true maps among enough points are right, the last map kept is right of somebody
// who stays and wrong of somebody who leaves, and feet on the floor are told from other contacts.
#include "inhabit/forecast/evaluate_contacts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "forecast/walker_data.h"
#include "inhabit/error.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit::forecast {
namespace {

const ScoreTable::Row* row_of(const ScoreTable& table, const std::string& contacts, const std::string& of) {
  for (const ScoreTable::Row& row : table.rows)
    if (row.labels[0].rfind(contacts, 0) == 0 && row.labels[1] == of) return &row;
  return nullptr;
}

TEST(EvaluateContacts, TrueMapsAreRightAndTheLastMapIsLeftBehind) {
  const TempFolder folder;
  Networks model;
  model.config = preset("compact");
  const std::vector<std::string> walkers = {write_walkers(folder / "walkers")};
  const ScoreTable table = evaluate_contacts(model, Data(walkers, "all", model.config, 30),
                                             Data(walkers, "all", dense_config(model.config), 30));
  ASSERT_EQ(table.columns.size(), 6U);
  ASSERT_EQ(table.rows.size(), 6U);  // no contact network: three sources
  const auto* real = row_of(table, "true, N = 1500", "feet on the floor");
  const auto* cut = row_of(table, "true, N = 1500, L = 12", "feet on the floor");
  const auto* kept = row_of(table, "last map kept", "feet on the floor");
  ASSERT_TRUE(real != nullptr && cut != nullptr && kept != nullptr);
  EXPECT_GT(real->cells[0].mean, 0.98);  // who walks on a floor has points of it near, sparse or dense
  EXPECT_GT(real->cells[1].mean, 0.9);
  EXPECT_LT(real->cells[2].mean, 250);
  EXPECT_GT(real->cells[2].mean, 1);
  EXPECT_LE(cut->cells[1].mean, 1);
  // At 1.2 m/s the place that was touched last is more than a metre behind after a second.
  EXPECT_GT(kept->cells[5].mean, real->cells[5].mean + 500);
  // Nobody touches anything but the floor.
  const auto* others = row_of(table, "true, N = 1500", "all others");
  ASSERT_NE(others, nullptr);
}

TEST(EvaluateContacts, SeveralDataSetsHaveTheirRowsAndCellsIntervals) {
  const TempFolder folder;
  Networks model;
  model.config = preset("compact");
  const auto table_of = [&](const std::vector<std::string>& folders) {
    return evaluate_contacts(model, Data(folders, "all", model.config, 30),
                             Data(folders, "all", dense_config(model.config), 30));
  };
  const std::string a = write_walkers(folder / "a"), b = write_walkers(folder / "b");
  const ScoreTable one = table_of({a}), both = table_of({a, b});
  EXPECT_EQ(both.labels, (std::vector<std::string>{"data", "contacts", "of"}));
  ASSERT_EQ(both.rows.size(), 3 * one.rows.size());
  for (size_t i = 0; i < both.rows.size(); ++i) {
    const size_t row = i % one.rows.size();
    EXPECT_EQ(both.rows[i].labels[0], i < one.rows.size() ? "all" : i < 2 * one.rows.size() ? "a" : "b");
    EXPECT_EQ(both.rows[i].labels[2], one.rows[row].labels[1]);
    for (size_t c = 0; c < one.columns.size(); ++c) {
      const auto mean = [&](const ScoreTable::Row& r) { return r.cells[c].mean; };
      const double first = mean(both.rows[one.rows.size() + row]), second = mean(both.rows[2 * one.rows.size() + row]);
      if (std::isnan(first) || std::isnan(second)) continue;
      EXPECT_EQ(first, mean(one.rows[row])) << "a set's row is that of the set alone";
      EXPECT_GE(mean(both.rows[row]), std::min(first, second) - 1e-9)
          << "ratios of sums lie between those of the parts";
      EXPECT_LE(mean(both.rows[row]), std::max(first, second) + 1e-9);
    }
  }
  // Of so many windows twice the uncertainty is smaller by about the root of two.
  const double once = one.rows[4].cells[5].interval, twice = both.rows[4].cells[5].interval;
  EXPECT_GT(once, 0);
  EXPECT_LT(twice, once);
  EXPECT_GT(twice, once / 2);
}

TEST(EvaluateContacts, RefusesAModelOfOtherJoints) {
  const TempFolder folder;
  Networks model;
  model.config = preset("compact");
  const std::vector<std::string> walkers = {write_walkers(folder / "walkers")};
  const Data data(walkers, "val", model.config, 30);
  Networks other = model;
  other.config.joints = 5;
  EXPECT_THAT(refusal_of([&] { return evaluate_contacts(other, data, data); }), ::testing::HasSubstr("22 joints"));
}

}  // namespace
}  // namespace inhabit::forecast
