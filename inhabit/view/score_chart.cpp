#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/json_text.h"
#include "inhabit/view/charts.h"

namespace inhabit {
namespace {

using ordered = nlohmann::ordered_json;

constexpr size_t kMostRows = 1000, kMostPanels = 400, kMostTicks = 200;
constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

struct Value {
  double mean = kNoValue, interval = kNoValue;
};

/// Whether a field of a row is one number: plain, none (null), or with its interval.
bool is_value(const ordered& field) {
  if (field.is_number() || field.is_null()) return true;
  const auto mean = field.is_object() ? field.find("mean") : field.end();
  return field.is_object() && field.contains("interval95") && mean != field.end() &&
         (mean->is_number() || mean->is_null());
}

Value value_of(const ordered& field) {
  const auto number = [](const ordered& n) { return n.is_number() ? n.get<double>() : kNoValue; };
  if (!field.is_object()) return {number(field), kNoValue};
  return {number(field.at("mean")), number(field.at("interval95"))};
}

/// Seconds in a name such as "0.5s"; NaN where it is another.
double seconds_in(const std::string& name) {
  char* end = nullptr;
  const double value = std::strtod(name.c_str(), &end);
  return end != name.c_str() && std::string(end) == "s" ? value : kNoValue;
}

/// Adds one value of a row to the panel that it belongs to.
struct TableChart {
  PageChart chart;
  std::map<std::string, size_t> panels;

  void add(const std::string& group, const std::string& title, const std::string& tick, bool bars,
           const std::string& row, const Value& value) {
    const auto [at, is_new] = panels.try_emplace(group + '\n' + title, chart.panels.size());
    if (is_new) {
      chart.panels.emplace_back();
      chart.panels.back().title = title;
      chart.panels.back().group = group;
      chart.panels.back().bars = bars;
    }
    PageChart::Panel& panel = chart.panels[at->second];
    auto place = std::find(panel.ticks.begin(), panel.ticks.end(), tick);
    if (place == panel.ticks.end()) {
      panel.ticks.push_back(tick);
      place = std::prev(panel.ticks.end());
    }
    const auto index = static_cast<size_t>(place - panel.ticks.begin());
    PageChart::Series& series = [&]() -> PageChart::Series& {
      for (PageChart::Series& known : panel.series)
        if (known.name == row) return known;
      panel.series.push_back({row, {}, {}, {}});
      return panel.series.back();
    }();
    series.y.resize(std::max(series.y.size(), index + 1), kNoValue);
    series.interval.resize(series.y.size(), kNoValue);
    series.y[index] = value.mean;
    series.interval[index] = value.interval;
  }

  void add_row(const ordered& row, const std::string& path) {
    std::vector<std::string> labels;
    for (const auto& [key, field] : row.items())
      if (field.is_string()) labels.push_back(field.get<std::string>());
    if (labels.empty()) throw Error(path, "has a row without a name");
    const std::string group = labels.size() > 1 ? labels.front() : "";
    std::string name = labels.back();
    for (size_t l = 1; l + 1 < labels.size(); ++l) name.insert(0, labels[l] + ", ");
    for (const auto& [key, field] : row.items()) {
      const std::string title = key;
      if (is_value(field)) add(group, title, title, true, name, value_of(field));
      if (!field.is_object() || is_value(field)) continue;
      if (field.size() > kMostTicks) throw Error(path, "has too many numbers of one name");
      size_t times = 0;
      for (const auto& [tick, value] : field.items()) times += std::isnan(seconds_in(tick)) ? 0 : 1;
      for (const auto& [tick, value] : field.items()) {
        if (!is_value(value)) continue;
        const bool over_time = times > 1 && !std::isnan(seconds_in(tick));
        const std::string panel = times > 1 && !over_time ? title + ", " + tick : title;
        add(group, panel, tick, !over_time, name, value_of(value));
      }
    }
    if (chart.panels.size() > kMostPanels) throw Error(path, "has too many kinds of numbers");
  }

  PageChart finished() {
    for (PageChart::Panel& panel : chart.panels)
      for (PageChart::Series& series : panel.series) {
        series.y.resize(panel.ticks.size(), kNoValue);
        series.interval.resize(panel.ticks.size(), kNoValue);
        const bool known = std::any_of(series.interval.begin(), series.interval.end(), [](double i) { return i > 0; });
        if (!known) series.interval.clear();
      }
    return std::move(chart);
  }
};

/// The rows of a table: the file's value itself, or its "rows"; nullptr where it has none.
const ordered* rows_of(const ordered& file) {
  const ordered* rows = &file;
  if (file.is_object()) {
    const auto found = file.find("rows");
    if (found == file.end()) return nullptr;
    rows = &*found;
  }
  const bool all = rows->is_array() && !rows->empty() &&
                   std::all_of(rows->begin(), rows->end(), [](const ordered& row) { return row.is_object(); });
  return all ? rows : nullptr;
}

}  // namespace

bool is_score_table(const std::string& path) {
  return rows_of(parse_json<ordered>(read_whole_file(path), path)) != nullptr;
}

PageChart read_score_chart(const std::string& path) { return parse_score_chart(read_whole_file(path), path); }

PageChart parse_score_chart(std::string_view text, const std::string& path) {
  const ordered file = parse_json<ordered>(text, path);
  const ordered* rows = rows_of(file);
  if (rows == nullptr) throw Error(path, "holds no table: no list of rows");
  if (rows->size() > kMostRows) throw Error(path, "has more than " + std::to_string(kMostRows) + " rows");
  TableChart table;
  for (const ordered& row : *rows) table.add_row(row, path);
  PageChart chart = table.finished();
  if (chart.panels.empty()) throw Error(path, "holds a table without a number");
  chart.x = "seconds";
  return chart;
}

}  // namespace inhabit
