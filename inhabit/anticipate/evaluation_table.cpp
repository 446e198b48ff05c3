#include <spdlog/fmt/fmt.h>

#include <array>

#include "inhabit/anticipate/evaluate.h"

namespace inhabit::anticipate {
namespace {

/// Curves of the table, as they are called.
struct Curve {
  const char *title, *key;
  std::vector<double> Scores::*values;
  int decimals;
};
constexpr std::array<Curve, 7> kCurves = {{{"NDMS", "ndms", &Scores::ndms, 3},
                                           {"NDMS as coded", "ndms_as_coded", &Scores::coded, 3},
                                           {"ratio to real motion", "ratio_to_real", &Scores::ratio, 2},
                                           {"joint error (mm)", "error_mm", &Scores::error, 0},
                                           {"joint error, best of N (mm)", "best_error_mm", &Scores::best_error, 0},
                                           {"root error (mm)", "root_error_mm", &Scores::root_error, 0},
                                           {"APD (m)", "apd_m", &Scores::apd, 2}}};

/// Rows of `actions` over the columns of `curves`, and what has one value a row where `single` is set.
ScoreTable score_table(const Table& table, const std::vector<const Table::Action*>& actions,
                       const std::vector<Curve>& curves, bool single) {
  ScoreTable out;
  out.labels = {"action", "method"};
  for (const Curve& curve : curves)
    for (const double h : table.horizons) {
      const std::string name = fmt::format("{:.1f}s", h);
      out.columns.push_back({curve.title, name, std::string(curve.key) + "/" + name, curve.decimals});
    }
  if (single) {
    out.columns.push_back({"", "NPSS", "npss", 3});
    out.columns.push_back({"", "APD 4s", "apd_of_4s_m", 2});
    out.columns.push_back({"", "speed", "speed_ratio", 2});
    out.columns.push_back({"", "of real", "late_ratio_to_real", 2});
    out.columns.push_back({"", "seam (mm)", "seam_mm", 1});
    out.columns.push_back({"", "intentions", "intentions_apart", 2});
  }
  for (const Table::Action* action : actions)
    for (const Scores& row : action->rows) {
      out.rows.push_back({{action->name, row.method}, {}});
      auto& cells = out.rows.back().cells;
      for (const Curve& curve : curves)
        for (const double value : row.*curve.values) cells.push_back({value, 0});
      if (single) {
        cells.push_back({row.npss, 0});
        for (const double value : {row.sequence_apd, row.speed_ratio, row.late_ratio, row.seam, row.intentions})
          cells.push_back({value, 0});
      }
    }
  return out;
}

std::vector<const Table::Action*> all_of(const Table& table) {
  std::vector<const Table::Action*> out;
  for (const Table::Action& action : table.actions) out.push_back(&action);
  for (const Table::Action& action : table.apart) out.push_back(&action);
  return out;
}

}  // namespace

std::string table_text(const Table& table) {
  std::string text = fmt::format("{} futures of each observation\n", table.samples);
  for (const Table::Action* action : all_of(table))
    text += fmt::format("{}: {} windows, {} words, real motion of {} words\n", action->name, action->windows,
                        action->words, action->training_words);
  text += text_of(score_table(table, all_of(table), {kCurves[0]}, true));
  for (size_t c = 1; c < kCurves.size() && !table.actions.empty(); ++c)
    text += text_of(score_table(table, {&table.actions.back()}, {kCurves[c]}, false));
  for (const Table::Action& action : table.apart) text += action.name + ": no other recording, and not in the mean\n";
  for (const std::string& action : table.left_out) text += action + ": no recording long enough\n";
  return text;
}

nlohmann::ordered_json table_json(const Table& table) {
  nlohmann::ordered_json out = {{"horizons_seconds", table.horizons}, {"samples", table.samples}};
  out["actions"] = nlohmann::ordered_json::array();
  for (const Table::Action* action : all_of(table))
    out["actions"].push_back({{"action", action->name},
                              {"windows", action->windows},
                              {"words", action->words},
                              {"training_words", action->training_words}});
  out["rows"] = rows_json(score_table(table, all_of(table), {kCurves.begin(), kCurves.end()}, true));
  out["apart"] = nlohmann::ordered_json::array();
  for (const Table::Action& action : table.apart) out["apart"].push_back(action.name);
  out["left_out"] = table.left_out;
  return out;
}

}  // namespace inhabit::anticipate
