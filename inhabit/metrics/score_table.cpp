#include "inhabit/metrics/score_table.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace inhabit {
namespace {

constexpr size_t kLeastWidth = 9;

std::string cell_text(const Estimate& e, int decimals, bool interval) {
  if (std::isnan(e.mean)) return "-";
  std::string text = fmt::format("{:.{}f}", e.mean, decimals);
  if (interval && e.interval > 0) text += fmt::format(" +- {:.{}f}", e.interval, decimals);
  return text;
}

nlohmann::ordered_json number(double value) {
  return std::isnan(value) ? nlohmann::ordered_json() : nlohmann::ordered_json(value);
}

}  // namespace

Estimate estimate(const std::vector<double>& runs) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (runs.empty()) return {kNone, kNone};
  const auto n = static_cast<double>(runs.size());
  double sum = 0, squares = 0;
  for (const double value : runs) sum += value;
  const double mean = sum / n;
  if (runs.size() == 1) return {mean, 0};
  for (const double value : runs) squares += (value - mean) * (value - mean);
  // Student's t at 0.975 by degrees of freedom.
  constexpr std::array<double, 30> t = {12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
                                        2.201,  2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086,
                                        2.080,  2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042};
  const size_t freedom = runs.size() - 1;
  const double factor = freedom <= t.size() ? t[freedom - 1] : 1.96 + 2.46 / static_cast<double>(freedom);
  return {mean, factor * std::sqrt(squares / (n - 1) / n)};
}

std::string text_of(const ScoreTable& table, bool intervals) {
  const size_t labels = table.labels.size(), columns = table.columns.size();
  std::vector<size_t> label_width(labels), width(columns);
  std::vector<std::vector<std::string>> cells;
  for (size_t l = 0; l < labels; ++l) label_width[l] = table.labels[l].size();
  for (size_t c = 0; c < columns; ++c) width[c] = std::max(kLeastWidth, table.columns[c].title.size() + 2);
  for (const ScoreTable::Row& row : table.rows) {
    for (size_t l = 0; l < labels; ++l) label_width[l] = std::max(label_width[l], row.labels[l].size());
    cells.emplace_back();
    for (size_t c = 0; c < columns; ++c) {
      cells.back().push_back(cell_text(row.cells[c], table.columns[c].decimals, intervals));
      width[c] = std::max(width[c], cells.back().back().size() + 2);
    }
  }
  const auto begins_group = [&](size_t c) {
    const std::string& group = table.columns[c].group;
    return !group.empty() && (c == 0 || table.columns[c - 1].group != group);
  };
  const auto line = [&](const std::vector<std::string>& names, const std::vector<std::string>& numbers) {
    std::string out;
    for (size_t l = 0; l < labels; ++l) out += fmt::format("{:<{}}", names[l], label_width[l] + 1);
    for (size_t c = 0; c < columns; ++c)
      out += (begins_group(c) ? "|" : "") + fmt::format("{:>{}}", numbers[c], width[c]);
    return out + "\n";
  };
  std::string text;
  if (std::any_of(table.columns.begin(), table.columns.end(), [](const auto& c) { return !c.group.empty(); })) {
    for (size_t l = 0; l < labels; ++l) text += std::string(label_width[l] + 1, ' ');
    for (size_t c = 0; c < columns;) {
      const std::string& group = table.columns[c].group;
      size_t wide = 0, end = c;
      for (; end < columns && table.columns[end].group == group; ++end) wide += width[end];
      text += (group.empty() ? "" : "|") + fmt::format("{:^{}}", group, wide);
      c = end;
    }
    text += "\n";
  }
  std::vector<std::string> titles;
  for (const ScoreTable::Column& column : table.columns) titles.push_back(column.title);
  text += line(table.labels, titles);
  for (size_t r = 0; r < table.rows.size(); ++r) text += line(table.rows[r].labels, cells[r]);
  for (const std::string& note : table.notes) text += note + "\n";
  return text;
}

nlohmann::ordered_json rows_json(const ScoreTable& table, bool intervals) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const ScoreTable::Row& row : table.rows) {
    nlohmann::ordered_json r;
    for (size_t l = 0; l < table.labels.size(); ++l) r[table.labels[l]] = row.labels[l];
    for (size_t c = 0; c < table.columns.size(); ++c) {
      const std::string& key = table.columns[c].key;
      const size_t slash = key.find('/');
      nlohmann::ordered_json& at = slash == std::string::npos ? r[key] : r[key.substr(0, slash)][key.substr(slash + 1)];
      const Estimate& e = row.cells[c];
      if (intervals)
        at = {{"mean", number(e.mean)}, {"interval95", number(e.interval)}};
      else
        at = number(e.mean);
    }
    rows.push_back(r);
  }
  return rows;
}

}  // namespace inhabit
