#include "inhabit/anticipate/evaluate.h"

#include <spdlog/fmt/fmt.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "inhabit/anticipate/fast_futures.h"
#include "inhabit/math/random.h"
#include "inhabit/metrics/diversity.h"
#include "inhabit/metrics/forecast_error.h"
#include "inhabit/metrics/ndms.h"
#include "inhabit/metrics/npss.h"

namespace inhabit::anticipate {
namespace {

using torch::Tensor;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// The motion words of every recording of an action (N, kappa, 12, 3).
Tensor action_words(const std::vector<Sequence>& sequences, const std::string& action, int64_t kappa) {
  std::vector<Tensor> words;
  for (const Sequence& s : sequences)
    if (s.action == action) words.push_back(pose_words(feature_poses(s.features), kappa));
  return torch::cat(words);
}

/// Similarity of the words of futures that end in each future frame: (S, T).
Tensor future_scores(const Tensor& past, const Tensor& futures, const WordIndex& database, int64_t kappa) {
  const Tensor led =
      torch::cat({past.slice(0, past.size(0) - kappa + 1).unsqueeze(0).expand({futures.size(0), -1, -1}), futures}, 1);
  std::vector<Tensor> scores;
  for (int64_t s = 0; s < futures.size(0); ++s)
    scores.push_back(plausibility(pose_words(feature_poses(led[s]), kappa), database));
  return torch::stack(scores);
}

/// Mean joint speed (m/s) of local poses (..., T, 22, 3).
double joint_speed(const Tensor& poses, double rate) {
  return (poses.slice(-3, 1) - poses.slice(-3, 0, -1)).norm(2, {-1}).mean().item<double>() * rate;
}

std::set<std::string> actions_of(const std::vector<Sequence>& sequences) {
  std::set<std::string> out;
  for (const Sequence& s : sequences) out.insert(s.action);
  return out;
}

/// Mean of what was added, without NaN.
struct Mean {
  double sum = 0;
  int64_t count = 0;
  void add(double value) {
    if (std::isnan(value)) return;
    sum += value;
    ++count;
  }
  double value() const { return count > 0 ? sum / static_cast<double>(count) : kNone; }
};

/// Calls visit(name, member) for every curve of scores.
template <class Scores, class Visit>
void visit_curves(Scores& scores, const Visit& visit) {
  visit("ndms", scores.ndms);
  visit("error_mm", scores.error);
  visit("best_error_mm", scores.best_error);
  visit("apd_m", scores.apd);
  visit("root_error_mm", scores.root_error);
}

/// One method's futures (S, T, F) of one window, measured at the horizons.
Scores measure(const Tensor& past, const Tensor& futures, const Tensor& truth, const WordIndex& database,
               const std::vector<double>& horizons, const Config& c, double real_speed) {
  Scores out;
  const Tensor scores = future_scores(past, futures, database, c.kappa).mean(0);  // (T)
  const Tensor poses = feature_poses(futures);
  const int64_t known = std::min(truth.size(0), futures.size(1));
  const auto [error, best] = futures_error(poses.slice(1, 0, known), feature_poses(truth.slice(0, 0, known)));
  const Tensor apd =
      futures.size(0) > 1 ? average_pairwise_distance(poses.flatten(2)) : torch::zeros({futures.size(1)});
  const auto path = [&](const Tensor& features) {  // (S, T, 2) on the ground, from the last observed frame on
    const auto place = torch::zeros({features.size(0), 3}), heading = torch::zeros({features.size(0)});
    return feature_joints(features, place, heading).select(2, 0).index_select(2, torch::tensor({0, 2}));
  };
  const Tensor root =
      (path(futures.slice(1, 0, known)) - path(truth.slice(0, 0, known).unsqueeze(0))).norm(2, {2}).mean(0);
  const auto span = static_cast<int64_t>(std::lround(0.4 * c.rate));
  for (const double horizon : horizons) {
    const auto end = static_cast<int64_t>(std::lround(horizon * c.rate));
    const bool real = end <= known;
    out.ndms.push_back(scores.slice(0, end - span, end).mean().item<double>());
    out.error.push_back(real ? error.select(1, end - 1).mean().item<double>() * 1000 : kNone);
    out.best_error.push_back(real ? best[end - 1].item<double>() * 1000 : kNone);
    out.root_error.push_back(real ? root[end - 1].item<double>() * 1000 : kNone);
    out.apd.push_back(apd[end - 1].item<double>());
  }
  const auto two = static_cast<int64_t>(2 * c.rate), four = static_cast<int64_t>(4 * c.rate);
  out.npss = kNone;
  if (known >= four) {
    const Tensor real = feature_poses(truth).slice(1, 1).slice(0, two, four).flatten(1).unsqueeze(0);
    Mean mean;
    for (int64_t s = 0; s < futures.size(0); ++s)
      mean.add(npss(real, poses[s].slice(1, 1).slice(0, two, four).flatten(1).unsqueeze(0)));
    out.npss = mean.value();
  }
  out.speed_ratio = futures.size(1) > four + 1 ? joint_speed(poses.slice(1, four), c.rate) / real_speed : kNone;
  return out;
}

Scores mean_scores(const std::vector<const Scores*>& all) {
  Scores out;
  out.method = all.front()->method;
  Mean power, speed;
  std::map<std::string, std::vector<Mean>> curves;
  for (const Scores* scores : all) {
    power.add(scores->npss);
    speed.add(scores->speed_ratio);
    visit_curves(*scores, [&](const char* name, const std::vector<double>& values) {
      std::vector<Mean>& curve = curves[name];
      curve.resize(values.size());
      for (size_t i = 0; i < values.size(); ++i) curve[i].add(values[i]);
    });
  }
  out.npss = power.value();
  out.speed_ratio = speed.value();
  visit_curves(out, [&](const char* name, std::vector<double>& values) {
    for (const Mean& mean : curves[name]) values.push_back(mean.value());
  });
  return out;
}

std::vector<Scores> means_by_method(const std::vector<std::vector<Scores>>& all) {
  std::vector<Scores> out;
  for (size_t method = 0; method < all.front().size(); ++method) {
    std::vector<const Scores*> same;
    same.reserve(all.size());
    for (const auto& rows : all) same.push_back(&rows[method]);
    out.push_back(mean_scores(same));
  }
  return out;
}

}  // namespace

Table evaluate(const Networks& networks, const std::vector<Sequence>& test, const Evaluation& options) {
  const torch::NoGradGuard no_gradients;
  const Config& c = networks.config;
  Table table;
  table.samples = options.samples;
  for (const double horizon : {0.4, 0.8, 1.2, 1.6, 2.0, 2.4, 2.8, 3.2, 3.6, 4.0, 10.0, 20.0, 30.0})
    if (horizon <= options.seconds + 1e-9) table.horizons.push_back(horizon);
  const auto frames = static_cast<int64_t>(std::lround(table.horizons.back() * c.rate));
  std::optional<FastFutures> ours;
  if (!networks.pose.is_empty()) ours.emplace(networks);

  std::map<std::string, std::vector<Cut>> windows;
  for (const Cut& window : test_windows(test, c, options.windows))
    windows[test[window.sequence].action].push_back(window);
  for (const std::string& action : actions_of(test)) {
    if (windows.count(action) == 0) {
      table.left_out.push_back(action);
      continue;
    }
    const WordIndex database(action_words(test, action, c.kappa));
    Mean real_speed;
    for (const Sequence& s : test)
      if (s.action == action) real_speed.add(joint_speed(feature_poses(s.features), c.rate));
    std::vector<std::vector<Scores>> scores;
    for (const Cut& window : windows[action]) {
      const Tensor& features = test[window.sequence].features;
      const Tensor past = observation(features, window.now, c.observed), truth = features.slice(0, window.now);
      std::vector<Scores> rows;
      const auto add = [&](const std::string& method, const Tensor& futures) {
        rows.push_back(measure(past, futures, truth, database, table.horizons, c, real_speed.value()));
        rows.back().method = method;
      };
      Tensor held = past.slice(0, past.size(0) - 1).expand({frames, -1}).clone();
      held.slice(1, kPoseFeatures, kPoseFeatures + 3).zero_();  // no step, no turn
      add("last pose held", held.unsqueeze(0));
      if (!networks.seq2seq.is_empty()) add("seq2seq", seq2seq_future(networks, past.unsqueeze(0), frames));
      if (!networks.ltd.is_empty()) add("LTD", ltd_future(networks, past.unsqueeze(0), frames));
      if (ours) {
        const uint64_t seed = item_seed(options.seed, window.sequence * 1000003 + static_cast<uint64_t>(window.now));
        add("ours", ours->forward(past.unsqueeze(0), draw_noise(c, options.samples, frames, seed), frames).features);
      }
      scores.push_back(rows);
    }
    table.actions.push_back(
        {action, static_cast<int64_t>(scores.size()), database.words().size(0), means_by_method(scores)});
  }
  if (table.actions.empty()) return table;
  std::vector<std::vector<Scores>> all;
  int64_t count = 0, words = 0;
  for (const auto& action : table.actions) {
    all.push_back(action.rows);
    count += action.windows;
    words += action.words;
  }
  table.actions.push_back({"mean", count, words, means_by_method(all)});
  return table;
}

namespace {

/// Curves of the table, as they are called.
struct Curve {
  const char *title, *key;
  std::vector<double> Scores::*values;
  int decimals;
};
constexpr std::array<Curve, 5> kCurves = {{{"NDMS", "ndms", &Scores::ndms, 3},
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
    out.columns.push_back({"", "speed", "speed_ratio", 2});
  }
  for (const Table::Action* action : actions)
    for (const Scores& row : action->rows) {
      out.rows.push_back({{action->name, row.method}, {}});
      auto& cells = out.rows.back().cells;
      for (const Curve& curve : curves)
        for (const double value : row.*curve.values) cells.push_back({value, 0});
      if (single) {
        cells.push_back({row.npss, 0});
        cells.push_back({row.speed_ratio, 0});
      }
    }
  return out;
}

std::vector<const Table::Action*> all_of(const Table& table) {
  std::vector<const Table::Action*> out;
  for (const Table::Action& action : table.actions) out.push_back(&action);
  return out;
}

}  // namespace

std::string table_text(const Table& table) {
  if (table.actions.empty()) return "";
  std::string text = fmt::format("{} futures of each observation\n", table.samples);
  text += text_of(score_table(table, all_of(table), {kCurves[0]}, true));
  for (size_t c = 1; c < kCurves.size(); ++c)
    text += text_of(score_table(table, {&table.actions.back()}, {kCurves[c]}, false));
  for (const std::string& action : table.left_out) text += action + ": no recording long enough\n";
  return text;
}

nlohmann::ordered_json table_json(const Table& table) {
  nlohmann::ordered_json out = {{"horizons_seconds", table.horizons}, {"samples", table.samples}};
  out["actions"] = nlohmann::ordered_json::array();
  for (const Table::Action& action : table.actions)
    out["actions"].push_back({{"action", action.name}, {"windows", action.windows}, {"words", action.words}});
  out["rows"] = rows_json(score_table(table, all_of(table), {kCurves.begin(), kCurves.end()}, true));
  out["left_out"] = table.left_out;
  return out;
}

double validation_ndms(const Networks& networks, const std::vector<Sequence>& sequences) {
  const Config& c = networks.config;
  constexpr int64_t kSamples = 4, kWindows = 4;
  const FastFutures ours(networks);
  const auto frames = static_cast<int64_t>(10 * c.rate);
  std::map<std::string, Mean> actions;
  std::map<std::string, WordIndex> databases;
  for (const Cut& window : test_windows(sequences, c, kWindows)) {
    const Sequence& s = sequences[window.sequence];
    auto database = databases.find(s.action);
    if (database == databases.end())
      database = databases.emplace(s.action, WordIndex(action_words(sequences, s.action, c.kappa))).first;
    const Tensor past = observation(s.features, window.now, c.observed);
    const Futures futures = ours.forward(past.unsqueeze(0), draw_noise(c, kSamples, frames, 1), frames);
    actions[s.action].add(future_scores(past, futures.features, database->second, c.kappa).mean().item<double>());
  }
  Mean mean;
  for (const auto& [action, value] : actions) mean.add(value.value());
  return mean.value();
}

double validation_error(const Networks& networks, bool ltd, const std::vector<Sequence>& sequences) {
  const Config& c = networks.config;
  Mean mean;
  for (const Cut& window : test_windows(sequences, c, 32)) {
    const Tensor& features = sequences[window.sequence].features;
    const Tensor past = observation(features, window.now, c.observed).unsqueeze(0);
    const int64_t known = std::min<int64_t>(static_cast<int64_t>(c.rate), features.size(0) - window.now);
    const Tensor future = ltd ? ltd_future(networks, past, known) : seq2seq_future(networks, past, known);
    const Tensor truth = features.slice(0, window.now, window.now + known);
    mean.add((feature_poses(future[0]) - feature_poses(truth)).norm(2, {2}).mean().item<double>());
  }
  return mean.value();
}

}  // namespace inhabit::anticipate
