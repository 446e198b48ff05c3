#include "inhabit/anticipate/evaluate.h"

#include <map>
#include <memory>
#include <set>

#include "inhabit/anticipate/futures.h"
#include "inhabit/anticipate/simple_futures.h"
#include "inhabit/anticipate/window_scores.h"
#include "inhabit/math/random.h"
#include "inhabit/metrics/method.h"

namespace inhabit::anticipate {
namespace {

using torch::Tensor;

/// A row of the table: futures (S, T, F) of an observation (t, F).
using FutureMethod = Method<Tensor, Tensor>;

std::vector<FutureMethod> methods_of(const Fold& fold, const Evaluation& options, int64_t frames) {
  const Networks& n = fold.networks;
  std::vector<FutureMethod> out = {
      {"last pose held", [=](const Tensor& past, uint64_t) { return held_future(past, frames).unsqueeze(0); }},
      {"constant velocity",
       [=](const Tensor& past, uint64_t) { return constant_velocity_future(past, frames).unsqueeze(0); }}};
  const auto retrieval = std::make_shared<const Retrieval>(fold.training, n.config.kappa);
  if (!retrieval->empty())
    out.push_back(
        {"retrieval", [=](const Tensor& past, uint64_t) { return retrieval->future(past, frames).unsqueeze(0); }});
  if (n.memory)
    out.push_back({"memory alone",
                   [=, &n](const Tensor& past, uint64_t seed) {
                     const FutureNoise noise = draw_noise(n.config, options.samples, frames, seed);
                     return memory_future(*n.memory, past, noise.choice.slice(1, 0, frames));
                   },
                   true});
  if (!n.seq2seq.is_empty())
    out.push_back(
        {"seq2seq", [=, &n](const Tensor& past, uint64_t) { return seq2seq_future(n, past.unsqueeze(0), frames); }});
  if (!n.ltd.is_empty())
    out.push_back({"LTD", [=, &n](const Tensor& past, uint64_t) { return ltd_future(n, past.unsqueeze(0), frames); }});
  if (n.forecasts()) {
    const FutureFunction ours = future_function(n);
    out.push_back({"ours",
                   [=, &n](const Tensor& past, uint64_t seed) {
                     const FutureNoise noise = draw_noise(n.config, options.samples, frames, seed);
                     return ours(past.unsqueeze(0), noise, frames).features;
                   },
                   true});
  }
  return out;
}

/// What was found of one action, over all folds.
struct Collected {
  int64_t windows = 0, words = 0;
  std::vector<std::string> methods;  // in the order of the first fold
  std::map<std::string, std::vector<Scores>> scores;
  std::map<std::string, SpectrumBatch> spectra;
  double real_ndms = 0, real_coded = 0;  // sums over the words of other recordings
  int64_t real_words = 0;
  Mean real_speed;
};

std::set<std::string> actions_of(const std::vector<Fold>& folds) {
  std::set<std::string> out;
  for (const Fold& fold : folds)
    for (const Sequence& s : fold.test) out.insert(s.action);
  return out;
}

/// Adds one fold's windows of an action. @param windows of the action
void collect(const Fold& fold, const std::string& action, const std::vector<Cut>& windows,
             const std::vector<FutureMethod>& methods, const std::vector<double>& horizons, const Evaluation& options,
             const std::function<void()>& done, Collected& out) {
  const Config& c = fold.networks.config;
  const WordIndex database(action_database(fold.test, action, c.kappa, options.words));
  Mean speed;
  for (const Sequence& s : fold.test)
    if (s.action == action) speed.add(joint_speed(feature_poses(s.features), c.rate));
  const Tensor others = action_words(fold.training, action, c.kappa, options.words);
  if (others.size(0) > 0) {
    const WordScores real = word_scores(others, database, options.words);
    out.real_ndms += real.ndms.sum().item<double>();
    out.real_coded += real.coded.sum().item<double>();
    out.real_words += others.size(0);
    for (const Sequence& s : fold.training)
      if (s.action == action) out.real_speed.add(joint_speed(feature_poses(s.features), c.rate) / speed.value());
  }
  out.words += database.words().size(0);
  out.windows += static_cast<int64_t>(windows.size());
  const Measure by{database, horizons, c, options.words, speed.value()};
  for (const FutureMethod& method : methods) {
    if (out.scores.count(method.name) == 0) out.methods.push_back(method.name);
    for (const Cut& window : windows) {
      const Tensor& features = fold.test[window.sequence].features;
      const Tensor past = observation(features, window.now, c.observed), truth = features.slice(0, window.now);
      const uint64_t seed = item_seed(options.seed, window.sequence * 1000003 + static_cast<uint64_t>(window.now));
      const Tensor futures = method.run(past, seed);
      out.scores[method.name].push_back(measure(past, futures, truth, by));
      out.spectra[method.name].add(futures, truth, c.rate);
      done();
    }
  }
}

Table::Action action_of(const std::string& name, const Collected& found, const std::vector<double>& horizons) {
  Table::Action out{name, found.windows, found.words, found.real_words, {}};
  for (const std::string& method : found.methods) {
    std::vector<const Scores*> same;
    for (const Scores& scores : found.scores.at(method)) same.push_back(&scores);
    out.rows.push_back(mean_scores(same));
    out.rows.back().method = method;
    out.rows.back().npss = found.spectra.at(method).npss();
  }
  if (found.real_words > 0) {
    Scores real;
    real.method = "real motion";
    visit_curves([&](auto curve) { (real.*curve).assign(horizons.size(), Scores::kNone); });
    real.ndms.assign(horizons.size(), found.real_ndms / static_cast<double>(found.real_words));
    real.coded.assign(horizons.size(), found.real_coded / static_cast<double>(found.real_words));
    real.speed_ratio = found.real_speed.value();
    out.rows.push_back(real);
  }
  add_shares(out.rows, horizons);
  return out;
}

Table::Action mean_of(const std::vector<Table::Action>& actions, const std::vector<double>& horizons) {
  Table::Action out{"mean", 0, 0, 0, {}};
  for (const Table::Action& action : actions) {
    out.windows += action.windows;
    out.words += action.words;
    out.training_words += action.training_words;
  }
  for (const Scores& first : actions.front().rows) {
    std::vector<const Scores*> same;
    for (const Table::Action& action : actions)
      for (const Scores& row : action.rows)
        if (row.method == first.method) same.push_back(&row);
    out.rows.push_back(mean_scores(same));
  }
  add_shares(out.rows, horizons);
  return out;
}

}  // namespace

Table evaluate(const std::vector<Fold>& folds, const Evaluation& options) {
  const torch::NoGradGuard no_gradients;
  Table table;
  table.samples = options.samples;
  for (const double horizon : {0.4, 0.8, 1.2, 1.6, 2.0, 2.4, 2.8, 3.2, 3.6, 4.0, 10.0, 20.0, 30.0})
    if (horizon <= options.seconds + 1e-9) table.horizons.push_back(horizon);
  std::map<std::string, Collected> found;
  bool compared = false;
  int64_t done = 0, all = 0;
  const auto one_more = [&] {
    if (options.progress) options.progress(++done, all);
  };
  for (const Fold& fold : folds) {
    const Config& c = fold.networks.config;
    const auto frames = static_cast<int64_t>(std::lround(table.horizons.back() * c.rate));
    const std::vector<FutureMethod> methods = methods_of(fold, options, frames);
    compared = compared || !fold.training.empty();
    std::map<std::string, std::vector<Cut>> windows;
    for (const Cut& window : test_windows(fold.test, c, options.windows))
      windows[fold.test[window.sequence].action].push_back(window);
    // How many the folds to come have is not known yet: they are alike.
    int64_t observations = 0;
    for (const auto& [action, own] : windows) observations += static_cast<int64_t>(own.size());
    const auto left = static_cast<int64_t>(folds.size() - static_cast<size_t>(&fold - folds.data()));
    all = done + left * observations * static_cast<int64_t>(methods.size());
    for (const auto& [action, own] : windows)
      collect(fold, action, own, methods, table.horizons, options, one_more, found[action]);
  }
  for (const std::string& action : actions_of(folds)) {
    const auto of = found.find(action);
    if (of == found.end())
      table.left_out.push_back(action);
    else if (compared && of->second.real_words == 0)
      table.apart.push_back(action_of(action, of->second, table.horizons));
    else
      table.actions.push_back(action_of(action, of->second, table.horizons));
  }
  if (!table.actions.empty()) table.actions.push_back(mean_of(table.actions, table.horizons));
  return table;
}

double validation_ndms(const Networks& networks, const std::vector<Sequence>& sequences) {
  const Config& c = networks.config;
  constexpr int64_t kSamples = 4, kWindows = 4;
  const FutureFunction ours = future_function(networks);
  const auto frames = static_cast<int64_t>(10 * c.rate);
  std::map<std::string, Mean> actions;
  std::map<std::string, WordIndex> databases;
  for (const Cut& window : test_windows(sequences, c, kWindows)) {
    const Sequence& s = sequences[window.sequence];
    auto database = databases.find(s.action);
    if (database == databases.end())
      database =
          databases.emplace(s.action, WordIndex(action_database(sequences, s.action, c.kappa, WordKind::poses))).first;
    const Tensor past = observation(s.features, window.now, c.observed);
    const Futures futures = ours(past.unsqueeze(0), draw_noise(c, kSamples, frames, 1), frames);
    actions[s.action].add(
        future_scores(past, futures.features, database->second, c.kappa, WordKind::poses).ndms.mean().item<double>());
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
