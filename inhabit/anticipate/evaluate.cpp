#include "inhabit/anticipate/evaluate.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <memory>
#include <numeric>
#include <set>

#include "inhabit/anticipate/futures.h"
#include "inhabit/anticipate/simple_futures.h"
#include "inhabit/anticipate/variational_futures.h"
#include "inhabit/anticipate/window_scores.h"
#include "inhabit/math/random.h"
#include "inhabit/metrics/forecast_error.h"
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
  if (!n.hisrep.is_empty())
    out.push_back(
        {"HisRep", [=, &n](const Tensor& past, uint64_t) { return hisrep_future(n, past.unsqueeze(0), frames); }});
  const auto stochastic = [&](const char* name, bool there, StochasticFutures futures) {
    if (!there) return;
    out.push_back({name,
                   [=, &n](const Tensor& past, uint64_t seed) {
                     return futures(n, past.unsqueeze(0), options.samples, frames, seed);
                   },
                   true});
  };
  stochastic("VAE", !n.vae.is_empty(), vae_futures);
  stochastic("DLow", !n.dlow.is_empty(), dlow_futures);
  stochastic("Mix&Match", !n.mix_match.is_empty(), mix_match_futures);
  stochastic("Grammar", !n.grammar.is_empty(), grammar_futures);
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

constexpr int64_t kMostMethods = 12;

/// What every observation is measured for, over all folds, a row each.
class Observations {
 public:
  Observations(int64_t count, const std::vector<double>& horizons, int64_t samples, int64_t labels)
      : horizons_(static_cast<int64_t>(horizons.size())),
        // NaN, which means leave out, where a fold lacks a method
        scores_(torch::full(
            {count, kMostMethods,
             static_cast<int64_t>(kCurveMembers.size()) * horizons_ + static_cast<int64_t>(kNumbers.size())},
            Scores::kNone, torch::kDouble)),
        spectra_(torch::full({count, kMostMethods, samples, 2}, Scores::kNone, torch::kDouble)),
        fractions_(torch::full({count, kMostMethods, labels}, Scores::kNone, torch::kDouble)),
        expected_(torch::full({count, labels}, Scores::kNone, torch::kDouble)) {}

  /// @param expected fractions of labels (C) by the recordings' transitions. @param first column of the fold's labels,
  /// which are no other fold's
  void expect(int64_t row, const Tensor& expected, int64_t first) {
    expected_[row].fill_(0).narrow(0, first, expected.size(0)).copy_(expected);
  }

  /// @param fractions of labels (C), undefined where nothing is expected. @param first as above
  void put(int64_t row, const FutureMethod& method, const Scores& scores, const Tensor& spectrum,
           const Tensor& fractions, int64_t first) {
    double* out = scores_[row][column(method)].data_ptr<double>();
    visit_curves([&](auto curve) { out = std::copy((scores.*curve).begin(), (scores.*curve).end(), out); });
    for (const auto number : kNumbers) *out++ = scores.*number;
    spectra_[row][column(method)].narrow(0, 0, spectrum.size(0)).copy_(spectrum);
    if (fractions.defined())
      fractions_[row][column(method)].fill_(0).narrow(0, first, fractions.size(0)).copy_(fractions);
  }

  /// A method's place, the next one where it is new: the same in every part, for all go through all folds.
  int64_t column(const FutureMethod& method) {
    const auto found = std::find(methods_.begin(), methods_.end(), method.name);
    if (found != methods_.end()) return found - methods_.begin();
    methods_.push_back(method.name);
    samples_.push_back(method.random ? spectra_.size(2) : 1);
    return static_cast<int64_t>(methods_.size()) - 1;
  }

  bool complete(const MeasuredParts& parts) {
    std::vector<int64_t> rows(static_cast<size_t>(scores_.size(0)));
    std::iota(rows.begin(), rows.end(), 0);
    std::map<std::string, Tensor> all = {{"scores", scores_}, {"spectra", spectra_}, {"fractions", fractions_}};
    return parts.complete(rows, all);  // fills them in place
  }

  const std::vector<std::string>& methods() const { return methods_; }

  /// Means over rows of a method.
  Scores mean(const std::string& method, const std::vector<int64_t>& rows) const {
    const auto column = std::find(methods_.begin(), methods_.end(), method) - methods_.begin();
    std::vector<Scores> each(rows.size());
    for (size_t k = 0; k < rows.size(); ++k) {
      const double* in = scores_[rows[k]][column].data_ptr<double>();
      visit_curves([&](auto curve) {
        (each[k].*curve).assign(in, in + horizons_);
        in += horizons_;
      });
      for (const auto number : kNumbers) each[k].*number = *in++;
    }
    std::vector<const Scores*> same;
    same.reserve(each.size());
    for (const Scores& scores : each) same.push_back(&scores);
    Scores out = mean_scores(same);
    out.method = method;
    out.npss = npss_of(spectra_.select(1, column)
                           .index_select(0, torch::tensor(rows))
                           .narrow(1, 0, samples_[static_cast<size_t>(column)]));
    out.intentions = intentions_apart(column, torch::tensor(rows));
    return out;
  }

 private:
  /// Half the sum of what the mean fractions of labels are off those expected, over the folds that have the method.
  double intentions_apart(int64_t column, const Tensor& rows) const {
    Tensor found = fractions_.select(1, column).index_select(0, rows), expected = expected_.index_select(0, rows);
    const Tensor known = found.isnan().any(1).logical_or(expected.isnan().any(1)).logical_not().nonzero().flatten();
    if (known.numel() == 0) return Scores::kNone;
    found = found.index_select(0, known);
    expected = expected.index_select(0, known);
    return (found.mean(0) - expected.mean(0)).abs().sum().item<double>() / 2;
  }

  static constexpr std::array kNumbers = {&Scores::sequence_apd, &Scores::speed_ratio, &Scores::seam};

  int64_t horizons_;
  std::vector<std::string> methods_;  // in the order of the first fold
  std::vector<int64_t> samples_;      // futures of each
  Tensor scores_, spectra_;           // (rows, methods, curves x horizons + numbers), (rows, methods, S, 2)
  Tensor fractions_, expected_;       // (rows, methods, C), (rows, C)
};

/// What was found of one action, over all folds.
struct Collected {
  int64_t words = 0;
  std::vector<int64_t> rows;             // of its observations
  std::set<std::string> methods;         // that observed them
  double real_ndms = 0, real_coded = 0;  // sums over the words of other recordings
  int64_t real_words = 0;
  Mean real_speed, real_step;
};

std::set<std::string> actions_of(const std::vector<Fold>& folds) {
  std::set<std::string> out;
  for (const Fold& fold : folds)
    for (const Sequence& s : fold.test) out.insert(s.action);
  return out;
}

/// Adds one fold's windows of an action. @param windows of the action. @param first row of them. @param first_label
/// column of the fold's labels
void collect(const Fold& fold, const std::string& action, const std::vector<Cut>& windows,
             const std::vector<FutureMethod>& methods, const std::vector<double>& horizons, const Evaluation& options,
             const std::function<void()>& done, int64_t first, int64_t first_label, Observations& observations,
             Collected& out) {
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
  const IntentionClusters& clusters = fold.networks.clusters;
  const bool labelled = clusters.poses.defined() || clusters.codes.defined();
  std::vector<Sequence> alike;  // people who do the same: others go on to what else there is
  std::copy_if(fold.training.begin(), fold.training.end(), std::back_inserter(alike),
               [&](const Sequence& s) { return s.action == action; });
  const Tensor transitions = labelled && !alike.empty() ? label_transitions(alike, clusters) : Tensor();
  const auto frames = static_cast<int64_t>(std::lround(horizons.back() * c.rate));
  for (size_t w = 0; w < windows.size(); ++w) {
    out.rows.push_back(first + static_cast<int64_t>(w));
    const Tensor& features = fold.test[windows[w].sequence].features;
    const Tensor past = observation(features, windows[w].now, c.observed);
    out.real_step.add(seam_step(past, features.slice(0, windows[w].now).unsqueeze(0)));
    if (transitions.defined())
      observations.expect(out.rows.back(), expected_fractions(transitions, last_label(past, clusters), frames),
                          first_label);
  }
  const Measure by{database, horizons, c, options.words, speed.value()};
  for (const FutureMethod& method : methods) {
    out.methods.insert(method.name);
    observations.column(method);
    for (size_t w = 0; w < windows.size(); ++w) {
      const int64_t row = first + static_cast<int64_t>(w);
      if (!options.parts.shard().has(row)) continue;
      const Cut& window = windows[w];
      const Tensor& features = fold.test[window.sequence].features;
      const Tensor past = observation(features, window.now, c.observed), truth = features.slice(0, window.now);
      const uint64_t seed = item_seed(options.seed, window.sequence * 1000003 + static_cast<uint64_t>(window.now));
      const Tensor futures = method.run(past, seed);
      observations.put(row, method, measure(past, futures, truth, by), spectrum_terms(futures, truth, c.rate),
                       transitions.defined() ? label_fractions(past, futures, clusters) : Tensor(), first_label);
      done();
    }
  }
}

Table::Action action_of(const std::string& name, const Collected& found, const Observations& observations,
                        const std::vector<double>& horizons) {
  Table::Action out{name, static_cast<int64_t>(found.rows.size()), found.words, found.real_words, {}};
  for (const std::string& method : observations.methods())
    if (found.methods.count(method) != 0) out.rows.push_back(observations.mean(method, found.rows));
  if (found.real_words > 0) {
    Scores real;
    real.method = "real motion";
    visit_curves([&](auto curve) { (real.*curve).assign(horizons.size(), Scores::kNone); });
    real.ndms.assign(horizons.size(), found.real_ndms / static_cast<double>(found.real_words));
    real.coded.assign(horizons.size(), found.real_coded / static_cast<double>(found.real_words));
    real.speed_ratio = found.real_speed.value();
    real.seam = found.real_step.value();
    out.rows.push_back(real);
  }
  add_ratios(out.rows, horizons);
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
  add_ratios(out.rows, horizons);
  return out;
}

}  // namespace

Table evaluate(const std::vector<Fold>& folds, const Evaluation& options) {
  const torch::NoGradGuard no_gradients;
  Table table;
  table.samples = options.samples;
  for (const double horizon : {0.4, 0.8, 1.2, 1.6, 2.0, 2.4, 2.8, 3.2, 3.6, 4.0, 10.0, 20.0, 30.0})
    if (horizon <= options.seconds + 1e-9) table.horizons.push_back(horizon);
  std::vector<std::map<std::string, std::vector<Cut>>> windows(folds.size());  // of each fold, by action
  int64_t count = 0;
  for (size_t f = 0; f < folds.size(); ++f)
    for (const Cut& window : test_windows(folds[f].test, folds[f].networks.config, options.windows)) {
      windows[f][folds[f].test[window.sequence].action].push_back(window);
      ++count;
    }
  int64_t labels = 0;
  for (const Fold& fold : folds) labels += fold.networks.config.labels;
  Observations observations(count, table.horizons, options.samples, labels);
  std::map<std::string, Collected> found;
  bool compared = false;
  int64_t mine = 0, done = 0, all = 0, first = 0, first_label = 0;
  for (int64_t row = 0; row < count; ++row) mine += options.parts.shard().has(row) ? 1 : 0;
  const auto one_more = [&] {
    if (options.progress) options.progress(++done, all);
  };
  for (size_t f = 0; f < folds.size(); ++f) {
    const Fold& fold = folds[f];
    const auto frames = static_cast<int64_t>(std::lround(table.horizons.back() * fold.networks.config.rate));
    const std::vector<FutureMethod> methods = methods_of(fold, options, frames);
    compared = compared || !fold.training.empty();
    all = mine * static_cast<int64_t>(methods.size());  // the same in all folds
    for (const auto& [action, own] : windows[f]) {
      collect(fold, action, own, methods, table.horizons, options, one_more, first, first_label, observations,
              found[action]);
      first += static_cast<int64_t>(own.size());
    }
    first_label += fold.networks.config.labels;
  }
  if (!observations.complete(options.parts)) {
    Table waits;
    waits.whole = false;
    return waits;
  }
  for (const std::string& action : actions_of(folds)) {
    const auto of = found.find(action);
    if (of == found.end())
      table.left_out.push_back(action);
    else if (compared && of->second.real_words == 0)
      table.apart.push_back(action_of(action, of->second, observations, table.horizons));
    else
      table.actions.push_back(action_of(action, of->second, observations, table.horizons));
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

double validation_error(const Networks& networks, BaselineFuture baseline, const std::vector<Sequence>& sequences) {
  const Config& c = networks.config;
  Mean mean;
  for (const Cut& window : test_windows(sequences, c, 32)) {
    const Tensor& features = sequences[window.sequence].features;
    const Tensor past = observation(features, window.now, c.observed).unsqueeze(0);
    const int64_t known = std::min<int64_t>(static_cast<int64_t>(c.rate), features.size(0) - window.now);
    const Tensor future = feature_poses(baseline(networks, past, known)),
                 truth = feature_poses(features.slice(0, window.now, window.now + known));
    mean.add(pose_error(future, truth.unsqueeze(0), 0).mean().item<double>());
  }
  return mean.value();
}

}  // namespace inhabit::anticipate
