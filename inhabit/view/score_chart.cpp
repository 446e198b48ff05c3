#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/json_text.h"
#include "inhabit/metrics/score_json.h"
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

  PageChart::Panel& panel_of(const std::string& group, const std::string& title, bool bars) {
    const auto [at, is_new] = panels.try_emplace(group + '\n' + title, chart.panels.size());
    if (is_new) {
      chart.panels.emplace_back();
      chart.panels.back().title = title;
      chart.panels.back().group = group;
      chart.panels.back().bars = bars;
    }
    return chart.panels[at->second];
  }

  static PageChart::Series& series_in(PageChart::Panel& panel, const std::string& name) {
    for (PageChart::Series& known : panel.series)
      if (known.name == name) return known;
    panel.series.push_back({name, {}, {}, {}});
    return panel.series.back();
  }

  void add(const std::string& group, const std::string& title, const std::string& tick, bool bars,
           const std::string& row, const Value& value) {
    PageChart::Panel& panel = panel_of(group, title, bars);
    auto place = std::find(panel.ticks.begin(), panel.ticks.end(), tick);
    if (place == panel.ticks.end()) {
      panel.ticks.push_back(tick);
      place = std::prev(panel.ticks.end());
    }
    const auto index = static_cast<size_t>(place - panel.ticks.begin());
    PageChart::Series& series = series_in(panel, row);
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

  /// The curve over seconds called `name`.
  PageChart::Series& curve(const std::string& title, const std::string& name) {
    return series_in(panel_of("", title, false), name);
  }

  /// Scores: bars of what is of all motions and of what is of each file, curves of what goes by time.
  void add_scores(const ordered& file, const std::string& path) {
    constexpr const char* kAll = "all";
    for (const auto& [key, field] : file.items()) {
      const std::string title = key;
      if (is_value(field)) add("", title, title, true, kAll, value_of(field));
      if (!field.is_array()) continue;
      if (field.size() > kMostRows) throw Error(path, "has more than " + std::to_string(kMostRows) + " " + title);
      std::map<std::string, size_t> motions;  // a file may hold several
      for (const ordered& entry : field) {
        if (!entry.is_object()) continue;
        if (const auto at = entry.find("seconds"), value = entry.find("value");
            at != entry.end() && at->is_number() && value != entry.end() && is_value(*value)) {
          PageChart::Series& series = curve(title, kAll);
          series.x.push_back(at->get<double>());
          series.y.push_back(value_of(*value).mean);
        }
        if (const auto of = entry.find("file"); of != entry.end() && of->is_string()) {
          std::string name = std::filesystem::path(of->get<std::string>()).filename().string();
          if (const size_t number = ++motions[name]; number > 1) name += fmt::format(" ({})", number);
          add_file(entry, name);
        }
      }
    }
    if (chart.panels.size() > kMostPanels) throw Error(path, "has too many kinds of numbers");
  }

  void add_file(const ordered& entry, const std::string& name) {
    for (const auto& [key, field] : entry.items()) {
      const std::string title = key;
      if (title == "deepest_frame") continue;  // a place, which is no measure
      if (is_value(field)) add("", title + ", each file", name, true, "each file", value_of(field));
      if (!field.is_array() || field.empty()) continue;
      PageChart::Series& series = curve(title, name);
      for (size_t second = 0; second < field.size(); ++second) {
        series.x.push_back(static_cast<double>(second + 1));
        series.y.push_back(is_value(field[second]) ? value_of(field[second]).mean : kNoValue);
      }
    }
  }

  PageChart finished() {
    for (PageChart::Panel& panel : chart.panels)
      for (PageChart::Series& series : panel.series) {
        if (panel.ticks.empty()) continue;  // a curve over seconds
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

/// Whether it is what `inhabit score --json` writes: an object with one of its numbers.
bool holds_scores(const ordered& file) {
  return file.is_object() && std::any_of(kScoreNames.begin(), kScoreNames.end(), [&](const char* score) {
           const auto found = file.find(score);
           return found != file.end() && is_value(*found);
         });
}

}  // namespace

bool is_score_table(const std::string& path) {
  const auto file = parse_json<ordered>(read_whole_file(path), path);
  return rows_of(file) != nullptr || holds_scores(file);
}

PageChart read_score_chart(const std::string& path) { return parse_score_chart(read_whole_file(path), path); }

PageChart parse_score_chart(std::string_view text, const std::string& path) {
  const ordered file = parse_json<ordered>(text, path);
  const ordered* rows = rows_of(file);
  if (rows == nullptr && !holds_scores(file)) throw Error(path, "holds neither scores nor a table: no list of rows");
  TableChart table;
  if (rows == nullptr) {
    table.add_scores(file, path);
  } else {
    if (rows->size() > kMostRows) throw Error(path, "has more than " + std::to_string(kMostRows) + " rows");
    for (const ordered& row : *rows) table.add_row(row, path);
  }
  PageChart chart = table.finished();
  if (chart.panels.empty()) throw Error(path, "holds a table without a number");
  chart.x = "seconds";
  return chart;
}

}  // namespace inhabit
