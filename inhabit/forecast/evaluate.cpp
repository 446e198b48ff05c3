#include "inhabit/forecast/evaluate.h"

#include <spdlog/fmt/fmt.h>

#include <memory>

#include "inhabit/forecast/fast_contact_network.h"
#include "inhabit/forecast/features.h"
#include "inhabit/forecast/motion_of.h"
#include "inhabit/metrics/forecast_error.h"
#include "inhabit/metrics/method.h"

namespace inhabit::forecast {
namespace {

constexpr int64_t kBatch = 8;

/// Windows that are forecast together.
struct Windows {
  torch::Tensor past;    // (B, P, J, 3)
  torch::Tensor truth;   // (B, T, J, 3)
  torch::Tensor points;  // (B, N, 3)
};
using ForecastMethod = Method<Windows, torch::Tensor>;  // joints (B, T, J, 3)

torch::Tensor last_pose(const Windows& w) {
  return w.past.slice(1, w.past.size(1) - 1).expand({-1, w.truth.size(1), -1, -1});
}

torch::Tensor constant_velocity(const Windows& w, int64_t root) {
  const int64_t past = w.past.size(1), future = w.truth.size(1);
  const torch::Tensor velocity =
      (w.past.slice(1, past - 1) - w.past.slice(1, past - 2, past - 1)).select(2, root).unsqueeze(2);
  return last_pose(w) + velocity * torch::arange(1, future + 1).view({1, future, 1, 1});
}

/// Baselines, then what the model's networks give.
std::vector<ForecastMethod> methods_of(const Networks& model) {
  const Config& config = model.config;
  std::vector<ForecastMethod> out = {
      {"last pose held", [](const Windows& w, uint64_t) { return last_pose(w); }},
      {"constant velocity", [root = config.root](const Windows& w, uint64_t) { return constant_velocity(w, root); }}};
  if (!model.ltd.is_empty())
    out.push_back({"LTD", [ltd = model.ltd](const Windows& w, uint64_t) mutable {
                     return ltd->forward(w.past.flatten(2)).view_as(w.truth);
                   }});
  const auto add = [&](const std::string& name, Contacts kind, const auto& contacts) {
    if (const Motion motion = motion_of(model, kind))
      out.push_back({name, [=](const Windows& w, uint64_t) { return motion(w.past, contacts(w)); }});
  };
  add("w/o contact", Contacts::none, [](const Windows&) { return torch::Tensor(); });
  if (!model.contact.is_empty())
    add("predicted contact", Contacts::predicted,
        [config, fast = std::make_shared<FastContactNetwork>(model.contact)](const Windows& w) {
          const torch::Tensor dct = fast->forward(w.points, contact_features(w.points, w.past, config), w.past);
          return contact_points(w.points, dct, config);
        });
  add("w/ true contact", Contacts::real,
      [config](const Windows& w) { return true_contact_points(w.points, w.truth, config); });
  return out;
}

/// Errors summed over windows (T), metres.
struct Sums {
  torch::Tensor path, pose;
  void add(const torch::Tensor& predicted, const torch::Tensor& truth, int64_t root) {
    const torch::Tensor a = path_error(predicted, truth, root).sum(0), b = pose_error(predicted, truth, root).sum(0);
    path = path.defined() ? path + a : a;
    pose = pose.defined() ? pose + b : b;
  }
};

}  // namespace

Table evaluate(const Networks& model, const Data& data) {
  torch::NoGradGuard no_grad;
  const Config& config = model.config;
  const int64_t P = config.past, T = config.future;
  const std::vector<ForecastMethod> methods = methods_of(model);
  std::vector<Sums> sums(methods.size());
  for (int64_t first = 0; first < data.size(); first += kBatch) {
    std::vector<torch::Tensor> joints, points;
    for (int64_t i = first; i < std::min(data.size(), first + kBatch); ++i) {
      const Sample s = data.sample(i, 0, false);
      joints.push_back(s.joints);
      points.push_back(s.points);
    }
    const torch::Tensor all = torch::stack(joints);
    const Windows windows{all.slice(1, 0, P), all.slice(1, P), torch::stack(points)};
    for (size_t m = 0; m < methods.size(); ++m) sums[m].add(methods[m].run(windows, 0), windows.truth, config.root);
  }

  Table table;
  table.windows = data.size();
  if (data.size() == 0) return table;
  for (int64_t quarter = 1; quarter <= 4; ++quarter)
    table.horizons.push_back(static_cast<double>(T * quarter / 4) / config.rate);
  for (size_t m = 0; m < methods.size(); ++m) {
    Scores row{methods[m].name, {}, {}};
    const auto fill = [&](const torch::Tensor& sum, std::vector<double>& out) {
      const torch::Tensor mm = sum * (1000.0 / static_cast<double>(data.size()));
      for (int64_t quarter = 1; quarter <= 4; ++quarter) out.push_back(mm[T * quarter / 4 - 1].item<double>());
      out.push_back(mm.mean().item<double>());
    };
    fill(sums[m].path, row.path);
    fill(sums[m].pose, row.pose);
    table.rows.push_back(row);
  }
  return table;
}

ScoreTable score_table(const Table& table) {
  ScoreTable out;
  out.labels = {"method"};
  for (const auto& [group, key] : {std::pair("Path Error (mm)", "path_error/"), {"Pose Error (mm)", "pose_error/"}}) {
    for (const double h : table.horizons)
      out.columns.push_back({group, fmt::format("{:.1f}s", h), key + fmt::format("{:.1f}s", h), 1});
    out.columns.push_back({group, "mean", key + std::string("mean"), 1});
  }
  for (const Scores& row : table.rows) {
    ScoreTable::Row r{{row.method}, {}};
    for (const auto* values : {&row.path, &row.pose})
      for (const double v : *values) r.cells.push_back({v, 0});
    out.rows.push_back(r);
  }
  out.notes = {fmt::format("{} windows", table.windows)};
  return out;
}

std::string table_text(const Table& table) { return text_of(score_table(table)); }

nlohmann::ordered_json table_json(const Table& table) {
  return {{"horizons_seconds", table.horizons},
          {"windows", table.windows},
          {"unit", "millimetres"},
          {"rows", rows_json(score_table(table))}};
}

}  // namespace inhabit::forecast
