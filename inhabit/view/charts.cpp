#include "inhabit/view/charts.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/json_text.h"

namespace inhabit {
namespace {

using ordered = nlohmann::ordered_json;

constexpr size_t kMostPoints = 2000;  // of a curve
constexpr size_t kMostCurves = 400;

/// Every n-th point and the last, so that a curve has a bounded number.
void thin(PageChart::Series& series) {
  const size_t count = series.x.size(), stride = (count + kMostPoints - 1) / kMostPoints;
  if (stride < 2) return;
  PageChart::Series out{series.name, {}, {}, {}};
  for (size_t i = 0; i < count; ++i)
    if (i % stride == 0 || i + 1 == count) {
      out.x.push_back(series.x[i]);
      out.y.push_back(series.y[i]);
    }
  series = std::move(out);
}

/// The panel called `title`, the series called `name` in it; made where they are not there.
PageChart::Series& series_of(PageChart& chart, const std::string& title, const std::string& name,
                             const std::string& where) {
  auto panel = std::find_if(chart.panels.begin(), chart.panels.end(), [&](const auto& p) { return p.title == title; });
  if (panel == chart.panels.end()) {
    if (chart.panels.size() == kMostCurves) throw Error(where + " has too many kinds of numbers");
    chart.panels.emplace_back();
    panel = std::prev(chart.panels.end());
    panel->title = title;
  }
  auto& all = panel->series;
  const auto series = std::find_if(all.begin(), all.end(), [&](const auto& s) { return s.name == name; });
  if (series != all.end()) return *series;
  if (all.size() == kMostCurves) throw Error(where + " has too many stages");
  all.push_back({name, {}, {}, {}});
  return all.back();
}

void read_log_line(PageChart& chart, const ordered& line, const std::string& where) {
  const auto step = line.find("step");
  if (!line.is_object() || step == line.end() || !step->is_number()) throw Error(where + " has no step");
  const auto named = line.find("stage");
  const std::string stage = named != line.end() && named->is_string() ? named->get<std::string>() : "training";
  const auto put = [&](const std::string& title, const ordered& value) {
    if (!value.is_number()) return;
    PageChart::Series& series = series_of(chart, title, stage, where);
    series.x.push_back(step->get<double>());
    series.y.push_back(value.get<double>());
  };
  for (const auto& [name, value] : line.items()) {
    if (name == "validation") put("validation", value);
    if (name == "rate") put("learning rate", value);
    if (name == "losses" && value.is_object())
      for (const auto& [loss, number] : value.items()) put("loss: " + loss, number);
  }
}

/// Validation, the total, the other losses, the learning rate.
int place_of(const std::string& title) {
  if (title == "validation") return 0;
  if (title == "loss: total") return 1;
  return title == "learning rate" ? 3 : 2;
}

}  // namespace

PageChart read_training_log(const std::string& path) { return parse_training_log(read_whole_file(path), path); }

PageChart parse_training_log(std::string_view text, const std::string& path) {
  PageChart chart;
  chart.x = "step";
  size_t number = 0;
  for (size_t at = 0; at < text.size();) {
    const size_t end = text.find('\n', at);
    if (end == std::string::npos && number > 0) break;  // is being written
    const std::string_view line = text.substr(at, end == std::string::npos ? end : end - at);
    at = end == std::string::npos ? text.size() : end + 1;
    ++number;
    if (line.find_first_not_of(" \r\t") == std::string_view::npos) continue;
    const std::string where = path + ": line " + std::to_string(number);
    ordered value;
    try {
      value = parse_json<ordered>(line, path);
    } catch (const Error&) {
      throw Error(where + " is not JSON");
    }
    read_log_line(chart, value, where);
  }
  if (chart.panels.empty()) throw Error(path, "is no training log: it has no line with losses or a validation");
  std::stable_sort(chart.panels.begin(), chart.panels.end(),
                   [](const auto& a, const auto& b) { return place_of(a.title) < place_of(b.title); });
  for (PageChart::Panel& panel : chart.panels)
    for (PageChart::Series& series : panel.series) thin(series);
  return chart;
}

}  // namespace inhabit
