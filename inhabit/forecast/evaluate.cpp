#include "inhabit/forecast/evaluate.h"

#include <spdlog/fmt/fmt.h>

#include <map>
#include <memory>

#include "inhabit/body/skeleton.h"
#include "inhabit/forecast/baselines.h"
#include "inhabit/forecast/fast_contact_network.h"
#include "inhabit/forecast/features.h"
#include "inhabit/forecast/motion_of.h"
#include "inhabit/metrics/bootstrap.h"
#include "inhabit/metrics/forecast_error.h"
#include "inhabit/metrics/method.h"

namespace inhabit::forecast {
namespace {

constexpr int64_t kBatch = 8, kColumns = 14, kResamples = 1000;

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

/// Of each row of (B, K, ...) the one that an index (B) tells.
torch::Tensor one_of_each(const torch::Tensor& all, const torch::Tensor& index) {
  return all.index({torch::arange(all.size(0)), index});
}

/// Baselines, then what the model's networks give.
std::vector<ForecastMethod> methods_of(const Networks& model) {
  const Config& config = model.config;
  std::vector<ForecastMethod> out = {
      {"last pose held", [](const Windows& w, uint64_t) { return last_pose(w); }},
      {"constant velocity", [root = config.root](const Windows& w, uint64_t) { return constant_velocity(w, root); }}};
  for (const Baseline& baseline : baselines_of(model))
    out.push_back({baseline.row,
                   [forecast = baseline.forecast](const Windows& w, uint64_t) { return forecast(w.past, w.points); }});
  const auto add = [&](const std::string& name, Contacts kind, const auto& contacts) {
    if (const Motion motion = motion_of(model, kind))
      out.push_back({name, [=](const Windows& w, uint64_t) { return motion(w.past, contacts(w)); }});
  };
  add("w/o contact", Contacts::none, [](const Windows&) { return torch::Tensor(); });
  if (!model.contact.is_empty()) {
    // Of the windows at hand: several rows take them.
    struct Predicted {
      FastContactNetwork network;
      torch::Tensor past, points;
    };
    const auto predicted = [config, last = std::make_shared<Predicted>(
                                        Predicted{FastContactNetwork(model.contact), {}, {}})](const Windows& w) {
      if (last->past.defined() && last->past.is_same(w.past)) return last->points;
      const torch::Tensor dct = last->network.forward(w.points, contact_features(w.points, w.past, config), w.past);
      last->past = w.past;
      return last->points = contact_points(w.points, dct, config);
    };
    add("predicted contact", Contacts::predicted, predicted);
    if (const Hypothesize hypothesize = hypothesize_of(model)) {
      const std::string many = std::to_string(config.articulated.hypotheses);
      out.push_back({"likeliest of " + many, [=](const Windows& w, uint64_t) {
                       const Hypotheses found = hypothesize(w.past, predicted(w));
                       return one_of_each(found.joints, found.log_probability.argmax(1));
                     }});
      out.push_back({"best of " + many, [=](const Windows& w, uint64_t) {
                       const torch::Tensor joints = hypothesize(w.past, predicted(w)).joints;
                       return one_of_each(joints, nearest_future(joints, w.truth));
                     }});
    }
    if (config.joints == kStandardJoints) {
      // What of the true contacts' gain is that of feet, which stand on the floor most of the time, and what is
      // others'.
      const auto true_of = [=](const torch::Tensor& joints) {
        return [=, which = joints.view({1, 1, -1, 1})](const Windows& w) {
          return torch::where(which, true_contact_points(w.points, w.truth, config), predicted(w));
        };
      };
      add("w/ true of feet", Contacts::real, true_of(foot_joints()));
      add("w/ true of others", Contacts::real, true_of(~foot_joints()));
    }
  }
  add("w/ true contact", Contacts::real,
      [config](const Windows& w) { return true_contact_points(w.points, w.truth, config); });
  return out;
}

/// Lengths (..., T, bones) of joints (..., T, J, 3).
torch::Tensor bone_lengths(const torch::Tensor& joints, const std::vector<int>& parents) {
  std::vector<int64_t> child, parent;
  for (size_t j = 0; j < parents.size(); ++j) {
    if (parents[j] < 0) continue;
    child.push_back(static_cast<int64_t>(j));
    parent.push_back(parents[j]);
  }
  const int64_t dim = joints.dim() - 2;
  return (joints.index_select(dim, torch::tensor(child)) - joints.index_select(dim, torch::tensor(parent)))
      .norm(2, {-1});
}

/// What is measured of each window, a row (B, columns) in metres: path at the horizons and its mean, pose likewise,
/// path and pose at the first frame, bones, and the bone that is off most.
torch::Tensor measured(const Windows& w, const torch::Tensor& predicted, int64_t root,
                       const std::vector<int>& parents) {
  const int64_t T = w.truth.size(1);
  const torch::Tensor path = path_error(predicted, w.truth, root), pose = pose_error(predicted, w.truth, root);
  const torch::Tensor bones = (bone_lengths(predicted, parents) - bone_lengths(w.past, parents).mean(1, true)).abs();
  std::vector<torch::Tensor> columns;
  for (const torch::Tensor& error : {path, pose}) {
    for (int64_t quarter = 1; quarter <= 4; ++quarter) columns.push_back(error.select(1, T * quarter / 4 - 1));
    columns.push_back(error.mean(1));
  }
  columns.insert(columns.end(), {path.select(1, 0), pose.select(1, 0), bones.mean({1, 2}), bones.amax({1, 2})});
  return torch::stack(columns, 1).to(torch::kDouble);
}

/// A row of the table from what was measured of its windows (W, columns).
Scores scores_of(const std::string& method, const std::string& data, const torch::Tensor& metres) {
  const torch::Tensor mm = metres * 1000, mean = mm.mean(0);
  const torch::Tensor drawn = bootstrap_counts(mm.size(0), kResamples, 1).matmul(mm) / static_cast<double>(mm.size(0));
  const auto at = [&](int64_t column) { return mean[column].item<double>(); };
  Scores row;
  row.method = method;
  row.data = data;
  for (int64_t i = 0; i < 5; ++i) {
    row.path.push_back(at(i));
    row.pose.push_back(at(5 + i));
  }
  row.seam_path = at(10);
  row.seam_pose = at(11);
  row.bones = at(12);
  row.bones_most = mm.select(1, 13).max().item<double>();
  for (int64_t i = 0; i < 13; ++i) {
    const torch::Tensor column = drawn.select(1, i).contiguous();
    row.intervals.push_back(half_interval({column.data_ptr<double>(), column.data_ptr<double>() + column.numel()}));
  }
  return row;
}

}  // namespace

Table evaluate(const Networks& model, const Data& data, const Progress& progress, const MeasuredParts& shared) {
  torch::NoGradGuard no_grad;
  const Config& config = model.config;
  const int64_t P = config.past, T = config.future;
  Table table;
  table.windows = data.size();
  if (data.size() == 0) return table;
  const std::vector<ForecastMethod> methods = methods_of(model);
  torch::Tensor metres = torch::zeros({data.size(), static_cast<int64_t>(methods.size()), kColumns}, torch::kDouble);
  std::vector<int64_t> batch_of;
  for (int64_t i = 0; i < data.size(); ++i) batch_of.push_back(i / kBatch);
  for (int64_t first = 0; first < data.size(); first += kBatch) {
    if (!shared.shard().has(first / kBatch)) continue;
    std::vector<torch::Tensor> joints, points;
    for (int64_t i = first; i < std::min(data.size(), first + kBatch); ++i) {
      const Sample s = data.sample(i, 0, false);
      joints.push_back(s.joints);
      points.push_back(s.points);
    }
    const torch::Tensor all = torch::stack(joints);
    const Windows windows{all.slice(1, 0, P), all.slice(1, P), torch::stack(points)};
    for (size_t m = 0; m < methods.size(); ++m)
      metres.slice(0, first, first + kBatch)
          .select(1, static_cast<int64_t>(m))
          .copy_(measured(windows, methods[m].run(windows, 0), config.root, data.windows().dataset(first).parents));
    if (progress) progress(std::min(data.size(), first + kBatch), data.size());
  }

  std::map<std::string, torch::Tensor> all = {{"metres", metres}};
  if (!shared.complete(batch_of, all)) return table;
  for (int64_t quarter = 1; quarter <= 4; ++quarter) {
    const int64_t frames = T * quarter / 4;
    table.horizons.push_back(static_cast<double>(frames) / config.rate);
  }
  const auto sets = data.windows().by_set();
  const std::vector<torch::Tensor> of_methods = all.at("metres").unbind(1);
  for (size_t m = 0; m < methods.size(); ++m) table.rows.push_back(scores_of(methods[m].name, "", of_methods[m]));
  if (sets.size() > 1)
    for (const auto& [set, windows] : sets)
      for (size_t m = 0; m < methods.size(); ++m)
        table.rows.push_back(scores_of(methods[m].name, set, of_methods[m].index_select(0, torch::tensor(windows))));
  return table;
}

ScoreTable score_table(const Table& table) {
  ScoreTable out;
  const bool several = !table.rows.empty() && !table.rows.back().data.empty();
  if (several) out.labels = {"data"};
  out.labels.emplace_back("method");
  for (const auto& [group, key] : {std::pair("Path Error (mm)", "path_error/"), {"Pose Error (mm)", "pose_error/"}}) {
    for (const double h : table.horizons)
      out.columns.push_back({group, fmt::format("{:.1f}s", h), key + fmt::format("{:.1f}s", h), 1});
    out.columns.push_back({group, "mean", key + std::string("mean"), 1});
  }
  out.columns.push_back({"Seam (mm)", "path", "seam/path", 1});
  out.columns.push_back({"Seam (mm)", "pose", "seam/pose", 1});
  out.columns.push_back({"Bones (mm)", "mean", "bones/mean", 1});
  out.columns.push_back({"Bones (mm)", "most", "bones/most", 1});
  for (const Scores& row : table.rows) {
    ScoreTable::Row r{{row.method}, {}};
    if (several) r.labels.insert(r.labels.begin(), row.data.empty() ? "all" : row.data);
    std::vector<double> values = row.path;
    values.insert(values.end(), row.pose.begin(), row.pose.end());
    values.insert(values.end(), {row.seam_path, row.seam_pose, row.bones, row.bones_most});
    for (size_t i = 0; i < values.size(); ++i)
      r.cells.push_back({values[i], i < row.intervals.size() ? row.intervals[i] : 0});
    out.rows.push_back(r);
  }
  out.notes = {fmt::format("{} windows", table.windows)};
  return out;
}

std::string table_text(const Table& table, bool intervals) {
  ScoreTable out = score_table(table);
  if (intervals) out.notes.front() += "; +- 95 % by bootstrap over windows";
  return text_of(out, intervals);
}

nlohmann::ordered_json table_json(const Table& table, bool intervals) {
  return {{"horizons_seconds", table.horizons},
          {"windows", table.windows},
          {"unit", "millimetres"},
          {"rows", rows_json(score_table(table), intervals)}};
}

}  // namespace inhabit::forecast
