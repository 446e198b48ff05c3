#include "inhabit/anticipate/window_scores.h"

#include <algorithm>

#include "inhabit/metrics/diversity.h"
#include "inhabit/metrics/forecast_error.h"
#include "inhabit/metrics/npss.h"

namespace inhabit::anticipate {

using torch::Tensor;

namespace {

/// Joints in the world (..., T, 22, 3) of features from the origin on.
Tensor from_origin(const Tensor& features) {
  std::vector<int64_t> one = features.sizes().vec();
  one.resize(one.size() - 2);
  const Tensor heading = torch::zeros(one);
  one.push_back(3);
  return feature_joints(features, torch::zeros(one), heading);
}

Tensor recorded(const Sequence& s) { return s.joints.defined() ? s.joints : from_origin(s.features); }

}  // namespace

Tensor action_database(const std::vector<Sequence>& sequences, const std::string& action, int64_t kappa,
                       WordKind kind) {
  std::vector<Tensor> words;
  for (const Sequence& s : sequences)
    if (s.action == action) words.push_back(database_words(recorded(s), kappa, s.stride, kind));
  return torch::cat(words);
}

Tensor action_words(const std::vector<Sequence>& sequences, const std::string& action, int64_t kappa, WordKind kind) {
  std::vector<Tensor> words;
  for (const Sequence& s : sequences)
    if (s.action == action) words.push_back(words_of(recorded(s).slice(0, 0, c10::nullopt, s.stride), kappa, kind));
  return words.empty() ? Tensor(torch::empty({0})) : torch::cat(words);
}

WordScores future_scores(const Tensor& past, const Tensor& futures, const WordIndex& database, int64_t kappa,
                         WordKind kind) {
  const Tensor with_past =
      torch::cat({past.slice(0, past.size(0) - kappa + 1).unsqueeze(0).expand({futures.size(0), -1, -1}), futures}, 1);
  const Tensor joints = kind == WordKind::package ? from_origin(with_past) : feature_poses(with_past);
  std::vector<Tensor> scores, coded;
  for (int64_t s = 0; s < futures.size(0); ++s) {
    const WordScores of = word_scores(words_of(joints[s], kappa, kind), database, kind);
    scores.push_back(of.ndms);
    coded.push_back(of.coded);
  }
  return {torch::stack(scores), torch::stack(coded)};
}

double joint_speed(const Tensor& poses, double rate) {
  return (poses.slice(-3, 1) - poses.slice(-3, 0, -1)).norm(2, {-1}).mean().item<double>() * rate;
}

double seam_step(const Tensor& past, const Tensor& futures) {
  const Tensor last = feature_poses(past.slice(0, past.size(0) - 1)), first = feature_poses(futures.select(1, 0));
  return (first - last).norm(2, {-1}).mean().item<double>() * 1000;
}

Tensor label_transitions(const std::vector<Sequence>& recordings, const IntentionClusters& clusters) {
  Tensor counts = torch::zeros({clusters.count(), clusters.count()}, torch::kDouble);
  for (const Sequence& s : recordings) {
    const Tensor labels = intention_labels(intention_poses(s.features), clusters);
    const Tensor pairs = labels.slice(0, 0, -1) * clusters.count() + labels.slice(0, 1);
    counts += pairs.bincount({}, counts.numel()).view_as(counts);
  }
  const Tensor sums = counts.sum(1, true);
  // A label that no recording leaves stays.
  return torch::where(sums > 0, counts / sums.clamp_min(1), torch::eye(clusters.count(), torch::kDouble));
}

Tensor expected_fractions(const Tensor& transitions, int64_t label, int64_t frames) {
  Tensor now = torch::zeros({transitions.size(0)}, torch::kDouble), sum = now.clone();
  now[label] = 1;
  for (int64_t t = 0; t < frames; ++t) {
    now = now.matmul(transitions);
    sum += now;
  }
  return sum / static_cast<double>(frames);
}

int64_t last_label(const Tensor& past, const IntentionClusters& clusters) {
  return intention_labels(intention_poses(past), clusters)[-1].item<int64_t>();
}

Tensor label_fractions(const Tensor& past, const Tensor& futures, const IntentionClusters& clusters) {
  Tensor counts = torch::zeros({clusters.count()}, torch::kInt64);
  for (const Tensor& future : futures.unbind(0))
    counts += intention_labels(intention_poses(torch::cat({past, future})), clusters)
                  .slice(0, past.size(0))
                  .bincount({}, clusters.count());
  return counts.to(torch::kDouble) / static_cast<double>(futures.size(0) * futures.size(1));
}

Scores measure(const Tensor& past, const Tensor& futures, const Tensor& truth, const Measure& by) {
  Scores out;
  const Config& c = by.config;
  const WordScores words = future_scores(past, futures, by.database, c.kappa, by.kind);
  const Tensor scores = words.ndms.mean(0), coded = words.coded.mean(0);  // (T)
  const Tensor poses = feature_poses(futures);
  const int64_t known = std::min(truth.size(0), futures.size(1));
  const auto [error, best] = futures_error(poses.slice(1, 0, known), feature_poses(truth.slice(0, 0, known)));
  const bool several = futures.size(0) > 1;
  const Tensor apd = several ? average_pairwise_distance(poses.flatten(2)) : torch::zeros({futures.size(1)});
  const auto path = [&](const Tensor& features) {  // (S, T, 2) on the ground, from the last observed frame on
    return from_origin(features).select(2, 0).index_select(2, torch::tensor({0, 2}));
  };
  const Tensor root =
      (path(futures.slice(1, 0, known)) - path(truth.slice(0, 0, known).unsqueeze(0))).norm(2, {2}).mean(0);
  const auto span = static_cast<int64_t>(std::lround(0.4 * c.rate));
  for (const double horizon : by.horizons) {
    const auto end = static_cast<int64_t>(std::lround(horizon * c.rate));
    const bool real = end <= known;
    out.ndms.push_back(scores.slice(0, end - span, end).mean().item<double>());
    out.coded.push_back(coded.slice(0, end - span, end).mean().item<double>());
    out.ratio.push_back(Scores::kNone);
    out.error.push_back(real ? error.select(1, end - 1).mean().item<double>() * 1000 : Scores::kNone);
    out.best_error.push_back(real ? best[end - 1].item<double>() * 1000 : Scores::kNone);
    out.root_error.push_back(real ? root[end - 1].item<double>() * 1000 : Scores::kNone);
    out.apd.push_back(apd[end - 1].item<double>());
  }
  out.seam = seam_step(past, futures);
  const auto four = static_cast<int64_t>(4 * c.rate);
  if (futures.size(1) >= four)
    out.sequence_apd = several ? sequence_pairwise_distance(poses.slice(1, 0, four).flatten(2)) : 0;
  if (futures.size(1) > four + 1) out.speed_ratio = joint_speed(poses.slice(1, four), c.rate) / by.real_speed;
  return out;
}

Tensor spectrum_terms(const Tensor& futures, const Tensor& truth, double rate) {
  const auto two = static_cast<int64_t>(2 * rate), four = static_cast<int64_t>(4 * rate);
  if (std::min(truth.size(0), futures.size(1)) < four)
    return torch::full({futures.size(0), 2}, Scores::kNone, torch::kDouble);
  const auto part = [&](const Tensor& features) {  // without the root, which stands at the origin
    return feature_poses(features.slice(-2, two, four)).slice(-2, 1).flatten(-2);
  };
  return npss_terms(part(truth).unsqueeze(0).expand({futures.size(0), -1, -1}), part(futures));
}

double npss_of(const Tensor& terms) {
  const Tensor known = terms.index({terms.select(2, 0).isnan().any(1).logical_not()}).sum(0);  // (S, 2)
  Mean mean;
  for (int64_t s = 0; s < known.size(0); ++s) mean.add((known[s][0] / known[s][1]).item<double>());
  return mean.value();
}

Scores mean_scores(const std::vector<const Scores*>& all) {
  Scores out;
  out.method = all.front()->method;
  const auto mean = [&](const auto& value) {
    Mean of;
    for (const Scores* scores : all) of.add(value(*scores));
    return of.value();
  };
  for (auto number : {&Scores::npss, &Scores::sequence_apd, &Scores::speed_ratio, &Scores::late_ratio, &Scores::seam,
                      &Scores::intentions})
    out.*number = mean([&](const Scores& s) { return s.*number; });
  visit_curves([&](auto curve) {
    for (size_t i = 0; i < (all.front()->*curve).size(); ++i)
      (out.*curve).push_back(mean([&](const Scores& s) { return (s.*curve)[i]; }));
  });
  return out;
}

void add_ratios(std::vector<Scores>& rows, const std::vector<double>& horizons) {
  const auto real = std::find_if(rows.begin(), rows.end(), [](const Scores& s) { return s.method == "real motion"; });
  if (real == rows.end()) return;
  const std::vector<double> ceiling = real->ndms;
  for (Scores& row : rows) {
    Mean late;
    for (size_t i = 0; i < horizons.size(); ++i) {
      row.ratio[i] = row.ndms[i] / ceiling[i];
      if (horizons[i] > 1.6 - 1e-9) late.add(row.ratio[i]);
    }
    row.late_ratio = late.value();
  }
}

}  // namespace inhabit::anticipate
