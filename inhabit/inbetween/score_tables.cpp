#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "inhabit/inbetween/evaluate.h"
#include "inhabit/inbetween/window_scores.h"

namespace inhabit::inbetween {
namespace {

struct Column {
  const char* title;
  const char* key;
  Score Scores::*value;
  int decimals;
};

constexpr std::array<Column, 20> kColumns = {
    {{"FID", "fid", &Scores::fid, 3},
     {"Foot Skating", "foot_skating", &Scores::skating, 3},
     {"Jerk (m/s3)", "jerk", &Scores::jerk, 1},
     {"Jerk / real", "jerk_ratio", &Scores::jerk_ratio, 2},
     {"MPJE Key (mm)", "mpje_key_mm", &Scores::key_error, 1},
     {"MPJE All (mm)", "mpje_all_mm", &Scores::error, 1},
     {"Coll. Frames", "collision_frame_ratio", &Scores::frame_ratio, 4},
     {"Coll. Vertices", "collision_vertex_ratio", &Scores::vertex_ratio, 5},
     {"Pene. Max (mm)", "penetration_max_mm", &Scores::penetration, 1},
     {"Coll. Frames", "close_collision_frame_ratio", &Scores::close_frame_ratio, 4},
     {"Coll. Vertices", "close_collision_vertex_ratio", &Scores::close_vertex_ratio, 5},
     {"Pene. Max (mm)", "close_penetration_max_mm", &Scores::close_penetration, 1},
     {"Acc. (m/s2)", "acceleration", &Scores::acceleration, 2},
     {"Frames, exact", "exact_collision_frame_ratio", &Scores::exact_frames, 4},
     {"Vertices, exact", "exact_collision_vertex_ratio", &Scores::exact_vertices, 5},
     {"Pene., exact", "exact_penetration_max_mm", &Scores::exact_depth, 1},
     {"Coll. Frames", "upright_collision_frame_ratio", &Scores::upright_frames, 4},
     {"Coll. Vertices", "upright_collision_vertex_ratio", &Scores::upright_vertices, 5},
     {"Pene. Max (mm)", "upright_penetration_max_mm", &Scores::upright_depth, 1},
     {"Apart (mm)", "seeds_apart_mm", &Scores::apart, 1}}};

/// Indices of kColumns.
std::vector<size_t> columns_of(Layout layout) {
  switch (layout) {
    case Layout::methods:
      return {0, 1, 2, 3, 4, 5, 6, 8};
    case Layout::close:
      return {9, 10, 11, 16, 17, 18};
    case Layout::recordings:
      return {1, 2, 12, 4, 6, 8, 13};
    case Layout::keys:
      return {0, 2, 5};
    case Layout::settings:
      return {0, 2, 5, 6, 8};
    case Layout::seeds:
      return {0, 2, 5, 19, 6};
    case Layout::collisions:
      return {6, 7, 8, 13, 14, 15};
  }
  return {};
}

Estimate cell_of(const Score& score, Layout layout, bool differences) {
  if (differences) return {score.difference, score.difference_interval};
  return {score.mean, layout == Layout::seeds ? score.seeds : score.interval};
}

std::vector<std::string> notes_of(const Table& table, Layout layout, bool differences, int64_t runs) {
  std::string note = fmt::format("{} windows", table.windows);
  if (layout == Layout::close)
    note += fmt::format(", {} frames closer to the scene than {:.0f} cm, {} of them without sitting",
                        table.close_frames, kCloseProximity * 100, table.upright_frames);
  if (table.noise > 0) note += fmt::format(", key frames with noise of level {:g}", table.noise);
  note += fmt::format(", {} seed{}", runs, runs == 1 ? "" : "s");
  note += layout == Layout::seeds ? "; +- 95 % over seeds, Student's t" : "; +- 95 % by bootstrap over windows";
  std::vector<std::string> out;
  if (differences) out.push_back("differences from " + table.against);
  out.push_back(note);
  const std::vector<size_t> columns = columns_of(layout);
  if (table.dimensions > 0 && std::count(columns.begin(), columns.end(), 0) > 0)
    out.push_back(fmt::format(
        "FID over {} principal components of {} features; of the real motion: between random halves of its windows",
        table.dimensions, kMotionFeatures));
  return out;
}

}  // namespace

const std::map<std::string, Layout>& layouts_by_name() {
  static const std::map<std::string, Layout> all = {{"methods", Layout::methods},       {"close", Layout::close},
                                                    {"recordings", Layout::recordings}, {"keys", Layout::keys},
                                                    {"settings", Layout::settings},     {"seeds", Layout::seeds},
                                                    {"collisions", Layout::collisions}};
  return all;
}

Layout layout_for(const Table& table, Layout asked) {
  return table.truth || asked == Layout::collisions ? asked : Layout::recordings;
}

ScoreTable score_table(const Table& table, Layout layout, bool differences) {
  std::set<std::string> choices, methods;
  for (const Scores& row : table.rows) {
    if (row.keyframes.empty()) continue;
    choices.insert(row.keyframes);
    methods.insert(row.method);
  }
  const bool one_choice = choices.size() <= 1, one_method = methods.size() <= 1, by_keys = layout == Layout::keys;
  const auto label = [&](const Scores& row) {
    if (row.keyframes.empty()) return row.method;
    if (by_keys && one_method) return row.keyframes;
    return one_choice && !by_keys ? row.method : row.method + ", " + row.keyframes;
  };
  ScoreTable out;
  out.labels = {by_keys && one_method ? "key frames" : "method"};
  const std::vector<size_t> columns = columns_of(layout);
  for (const size_t c : columns) {
    const bool second = c >= 16, first = layout == Layout::close && !second;
    out.columns.push_back({first    ? "close frames"
                           : second ? "nobody sits"
                                    : "",
                           kColumns[c].title, kColumns[c].key, kColumns[c].decimals});
  }
  int64_t runs = 1;
  for (const Scores& row : table.rows) {
    out.rows.push_back({{label(row)}, {}});
    for (const size_t c : columns)
      out.rows.back().cells.push_back(cell_of(row.*kColumns[c].value, layout, differences));
    runs = std::max(runs, row.runs);
  }
  out.notes = notes_of(table, layout, differences, runs);
  return out;
}

std::string table_text(const Table& table, Layout layout, bool differences) {
  return text_of(score_table(table, layout, differences), /*intervals=*/true);
}

nlohmann::ordered_json table_json(const Table& table) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  const auto number = [](double value) {
    return std::isnan(value) ? nlohmann::ordered_json() : nlohmann::ordered_json(value);
  };
  for (const Scores& row : table.rows) {
    nlohmann::ordered_json out = {{"method", row.method}, {"keyframes", row.keyframes}, {"runs", row.runs}};
    for (const Column& column : kColumns) {
      const Score& s = row.*column.value;
      out[column.key] = {{"mean", number(s.mean)},
                         {"interval95", number(s.interval)},
                         {"interval95_seeds", number(s.seeds)},
                         {"difference", number(s.difference)},
                         {"difference_interval95", number(s.difference_interval)}};
    }
    rows.push_back(out);
  }
  return {{"windows", table.windows},
          {"close_frames", table.close_frames},
          {"upright_close_frames", table.upright_frames},
          {"fid_dimensions", table.dimensions},
          {"noise", table.noise},
          {"truth", table.truth},
          {"against", table.against},
          {"rows", rows}};
}

}  // namespace inhabit::inbetween
