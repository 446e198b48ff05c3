#include "inhabit/forecast/evaluate.h"

#include <spdlog/fmt/fmt.h>

#include <optional>

#include "inhabit/forecast/fast_contact_network.h"
#include "inhabit/forecast/fast_motion_network.h"
#include "inhabit/forecast/features.h"
#include "inhabit/metrics/forecast_error.h"

namespace inhabit::forecast {
namespace {

constexpr int64_t kBatch = 8;

struct Sums {
  torch::Tensor path, pose;  // (T) summed over windows, metres
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
  std::vector<std::pair<std::string, Sums>> methods = {{"last pose held", {}}, {"constant velocity", {}}};
  if (!model.ltd.is_empty()) methods.push_back({"LTD", {}});
  if (!model.no_contact.is_empty()) methods.push_back({"w/o contact", {}});
  if (!model.contact.is_empty() && !model.motion.is_empty()) methods.push_back({"predicted contact", {}});
  if (!model.motion.is_empty()) methods.push_back({"w/ true contact", {}});

  std::optional<FastContactNetwork> contact;
  std::optional<FastMotionNetwork> motion, no_contact;
  if (!model.contact.is_empty()) contact.emplace(model.contact);
  if (!model.motion.is_empty()) motion.emplace(model.motion);
  if (!model.no_contact.is_empty()) no_contact.emplace(model.no_contact);

  for (int64_t first = 0; first < data.size(); first += kBatch) {
    std::vector<torch::Tensor> joints, points;
    for (int64_t i = first; i < std::min(data.size(), first + kBatch); ++i) {
      const Sample s = data.sample(i, 0, false);
      joints.push_back(s.joints);
      points.push_back(s.points);
    }
    const torch::Tensor all = torch::stack(joints), scene = torch::stack(points);
    const torch::Tensor past = all.slice(1, 0, P), truth = all.slice(1, P);
    const torch::Tensor last = past.slice(1, P - 1).expand({-1, T, -1, -1});
    const torch::Tensor velocity =
        (past.slice(1, P - 1) - past.slice(1, P - 2, P - 1)).select(2, config.root).unsqueeze(2);
    const torch::Tensor moved = last + velocity * torch::arange(1, T + 1).view({1, T, 1, 1});
    auto run = [&](const FastMotionNetwork& network, const torch::Tensor& contacts) {
      return forecast_joints(network.forward(past, contacts), config.root);
    };
    for (auto& [name, sums] : methods) {
      if (name == "last pose held") sums.add(last, truth, config.root);
      if (name == "constant velocity") sums.add(moved, truth, config.root);
      if (name == "LTD") {
        nn::TrajectoryGraph trajectory = model.ltd;
        sums.add(trajectory->forward(past.flatten(2)).view_as(truth), truth, config.root);
      }
      if (name == "w/o contact") sums.add(run(*no_contact, {}), truth, config.root);
      if (name == "predicted contact") {
        const torch::Tensor dct = contact->forward(scene, contact_features(scene, past, config), past);
        sums.add(run(*motion, contact_points(scene, dct, config)), truth, config.root);
      }
      if (name == "w/ true contact")
        sums.add(run(*motion, true_contact_points(scene, truth, config)), truth, config.root);
    }
  }

  Table table;
  table.windows = data.size();
  for (int64_t quarter = 1; quarter <= 4; ++quarter) {
    const int64_t frame = T * quarter / 4;
    table.horizons.push_back(static_cast<double>(frame) / config.rate);
  }
  for (const auto& [name, sums] : methods) {
    if (!sums.path.defined()) continue;
    Scores row{name, {}, {}};
    auto fill = [&](const torch::Tensor& sum, std::vector<double>& out) {
      const torch::Tensor mm = sum * (1000.0 / static_cast<double>(data.size()));
      for (int64_t quarter = 1; quarter <= 4; ++quarter) out.push_back(mm[T * quarter / 4 - 1].item<double>());
      out.push_back(mm.mean().item<double>());
    };
    fill(sums.path, row.path);
    fill(sums.pose, row.pose);
    table.rows.push_back(row);
  }
  return table;
}

std::string table_text(const Table& table) {
  std::string text = fmt::format("{:<20}|{:^45}|{:^45}\n{:<20}|", "", "Path Error (mm)", "Pose Error (mm)", "method");
  for (int block = 0; block < 2; ++block) {
    for (const double h : table.horizons) text += fmt::format("{:>8.1f}s", h);
    text += fmt::format("{:>9}{}", "mean", block == 0 ? "|" : "\n");
  }
  for (const Scores& row : table.rows) {
    text += fmt::format("{:<20}|", row.method);
    for (const double v : row.path) text += fmt::format("{:>9.1f}", v);
    text += "|";
    for (const double v : row.pose) text += fmt::format("{:>9.1f}", v);
    text += "\n";
  }
  return text + fmt::format("{} windows\n", table.windows);
}

nlohmann::json table_json(const Table& table) {
  nlohmann::json out = {{"horizons_seconds", table.horizons}, {"windows", table.windows}, {"unit", "millimetres"}};
  for (const Scores& row : table.rows) {
    nlohmann::json r = {{"method", row.method}};
    auto named = [&](const std::vector<double>& values) {
      nlohmann::json j;
      for (size_t i = 0; i < table.horizons.size(); ++i) j[fmt::format("{:.1f}s", table.horizons[i])] = values[i];
      j["mean"] = values.back();
      return j;
    };
    r["path_error"] = named(row.path);
    r["pose_error"] = named(row.pose);
    out["rows"].push_back(r);
  }
  return out;
}

}  // namespace inhabit::forecast
