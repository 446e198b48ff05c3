#include "inhabit/anticipate/motion_memory.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "inhabit/anticipate/features.h"
#include "inhabit/anticipate/sample.h"
#include "inhabit/error.h"
#include "inhabit/metrics/motion_words.h"
#include "inhabit/metrics/ndms.h"

namespace inhabit::anticipate {

using torch::Tensor;

namespace {

constexpr int64_t kLeastFollowed = 10;   // frames that must follow a place, so that something is remembered
constexpr int64_t kMostPlaces = 25'000;  // of one side: words of twice as many take 60 MB
constexpr int64_t kTypicalFrames = 50;   // that `typical` is the mean of
constexpr int64_t kMeanFrames = 25;      // in which the mean of the nearest fades into the one that was drawn
constexpr size_t kMeanOf = 8;            // recordings
constexpr double kMeanDistance = 0.02;   // metres: a recording so much farther away counts e times less in the mean

Tensor words_of_features(const Tensor& features, int64_t kappa) {
  return pose_words(feature_poses(features), kappa).flatten(1);
}

/// Mean of the next `frames` values from each on, fewer at the end.
Tensor mean_ahead(const Tensor& values, int64_t frames) {
  const int64_t n = values.size(0);
  const Tensor sum = torch::cat({torch::zeros({1}, torch::kFloat64), values.to(torch::kFloat64).cumsum(0)});
  const Tensor first = torch::arange(n), last = (first + frames).clamp_max(n);
  return ((sum.index_select(0, last) - sum.index_select(0, first)) / (last - first)).to(torch::kFloat32);
}

}  // namespace

std::vector<Tensor> typical_motion(const std::vector<Tensor>& features, const std::vector<std::string>& actions,
                                   int64_t kappa) {
  const torch::NoGradGuard no_gradients;
  std::vector<Tensor> words, scores(features.size());
  for (const Tensor& f : features)
    words.push_back(
        torch::cat({pose_words(feature_poses(f), kappa), pose_words(feature_poses(mirrored_features(f)), kappa)}));
  std::map<std::string, std::pair<double, int64_t>> sums;
  for (size_t i = 0; i < features.size(); ++i) {
    std::vector<Tensor> others;
    for (size_t j = 0; j < features.size(); ++j)
      if (j != i && actions[j] == actions[i] && words[j].size(0) > 0) others.push_back(words[j]);
    if (others.empty() || words[i].size(0) == 0) continue;
    const Tensor own = words[i].slice(0, 0, words[i].size(0) / 2);
    scores[i] = plausibility(own, WordIndex(torch::cat(others)), NdmsForm::equation).to(torch::kFloat32);
    auto& [sum, count] = sums[actions[i]];
    sum += scores[i].sum().item<double>();
    count += scores[i].size(0);
  }
  std::vector<Tensor> out;
  for (size_t i = 0; i < features.size(); ++i) {
    out.push_back(torch::zeros({features[i].size(0)}));
    if (!scores[i].defined()) continue;
    const auto& [sum, count] = sums[actions[i]];
    const Tensor ahead = mean_ahead(scores[i] - sum / static_cast<double>(count), kTypicalFrames);
    out.back().slice(0, kappa - 1, kappa - 1 + ahead.size(0)).copy_(ahead);
  }
  return out;
}

MotionMemory::MotionMemory(std::vector<Remembered> recordings, const IntentionClusters& clusters, const Choice& by,
                           const std::string& subject)
    : by_(by), recordings_(std::move(recordings)) {
  const torch::NoGradGuard no_gradients;
  int64_t places = 0;
  for (const Remembered& r : recordings_)
    places += std::max<int64_t>(0, r.features.size(0) - kLeastFollowed - by_.kappa + 1);
  if (places == 0) throw Error(subject, "the recordings are too short to be remembered");
  stride_ = (places + kMostPlaces - 1) / kMostPlaces;
  std::vector<Tensor> words, typical;
  int64_t count = 0;
  for (const Remembered& r : recordings_)
    for (const bool mirrored : {false, true}) {
      Motion m;
      m.features = (mirrored ? mirrored_features(r.features) : r.features).contiguous();
      m.changes = torch::cat(
          {torch::zeros_like(m.features.slice(0, 0, 1)), m.features.slice(0, 1) - m.features.slice(0, 0, -1)});
      m.labels = intention_labels(intention_poses(m.features), clusters);
      m.first_word = count;
      m.words = 0;
      const int64_t last = m.features.size(0) - kLeastFollowed;  // a word ends there at the latest
      if (last >= by_.kappa) {
        words.push_back(words_of_features(m.features.slice(0, 0, last), by_.kappa).slice(0, 0, c10::nullopt, stride_));
        m.words = words.back().size(0);
        typical.push_back(r.typical.slice(0, by_.kappa - 1, last, stride_));
      }
      count += m.words;
      motions_.push_back(m);
    }
  words_ = torch::cat(words).contiguous();
  squared_ = words_.square().sum(1);
  typical_ = torch::cat(typical).contiguous();
  for (const Motion& m : motions_)
    at_end_.push_back(m.features.size(0) < by_.kappa ? std::vector<Candidate>() : candidates(m.features));
}

std::vector<MotionMemory::Candidate> MotionMemory::candidates(const Tensor& seen) const {
  const Tensor word = words_of_features(seen.slice(0, seen.size(0) - by_.kappa), by_.kappa)[0];
  const Tensor squared = (squared_ - 2 * words_.mv(word) + word.square().sum()).clamp_min(0);
  const Tensor distance = (squared / (static_cast<double>(word.size(0)) / 3)).sqrt();
  const float *d = distance.data_ptr<float>(), *typical = typical_.data_ptr<float>();
  std::vector<Candidate> out;
  for (size_t m = 0; m < motions_.size(); ++m) {
    const Motion& motion = motions_[m];
    if (motion.words == 0) continue;
    Candidate best{static_cast<int64_t>(m), -1, 0, -1, 0};
    for (int64_t i = 0; i < motion.words; ++i) {
      const int64_t row = motion.first_word + i, frame = by_.kappa + i * stride_;
      const double score = -d[row] / by_.distance + by_.typical * typical[row];
      if (best.frame < 0 || score > best.score) {
        best.frame = frame;
        best.score = score;
      }
      if (best.nearest < 0 || d[row] < best.distance) {
        best.nearest = frame;
        best.distance = d[row];
      }
    }
    out.push_back(best);
  }
  return out;
}

Followed MotionMemory::nearest_mean(std::vector<Candidate> among, int64_t without) const {
  among.erase(std::remove_if(among.begin(), among.end(), [&](const Candidate& c) { return c.motion / 2 == without; }),
              among.end());
  std::stable_sort(among.begin(), among.end(),
                   [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
  among.resize(std::min(among.size(), kMeanOf));
  Followed out{torch::zeros({kMeanFrames, kFeatureCount}), torch::zeros({kMeanFrames, kFeatureCount}), {}};
  double sum = 0;
  for (const Candidate& c : among) {
    const double weight = std::exp((among.front().distance - c.distance) / kMeanDistance);
    const Motion& m = motions_[static_cast<size_t>(c.motion)];
    // A recording that ends sooner stays as it is then.
    const Tensor rows = torch::arange(c.nearest, c.nearest + kMeanFrames),
                 last = rows.clamp_max(m.features.size(0) - 1);
    out.features += weight * m.features.index_select(0, last);
    out.changes += weight * m.changes.index_select(0, last) * (rows == last).unsqueeze(1);
    sum += weight;
  }
  out.features /= sum;
  out.changes /= sum;
  return out;
}

const MotionMemory::Candidate& MotionMemory::drawn(const std::vector<Candidate>& among, int64_t without, double uniform,
                                                   const float* label_scores) const {
  std::vector<double> weight;
  double highest = -std::numeric_limits<double>::infinity();
  for (const Candidate& c : among) {
    double score = c.motion / 2 == without ? -std::numeric_limits<double>::infinity() : c.score;
    if (label_scores != nullptr) {
      const Tensor& labels = motions_[static_cast<size_t>(c.motion)].labels;
      score += label_scores[labels.data_ptr<int64_t>()[c.frame]];
    }
    weight.push_back(score);
    highest = std::max(highest, score);
  }
  if (std::isinf(highest)) return drawn(among, -1, uniform, label_scores);  // nothing else is remembered
  double sum = 0;
  for (double& w : weight) sum += w = std::exp(w - highest);
  double left = uniform * sum;
  size_t at = 0;
  for (size_t i = 0; i < among.size(); ++i) {
    if (weight[i] <= 0) continue;
    at = i;
    left -= weight[i];
    if (left < 0) break;
  }
  return among[at];
}

Followed MotionMemory::follow(const Tensor& past, const Tensor& choice, const std::vector<int64_t>& without,
                              const LabelScores& scores, const LabelsSeen& seen) const {
  const torch::NoGradGuard no_gradients;
  const int64_t samples = choice.size(0), frames = choice.size(1);
  Followed out{torch::empty({samples, frames, kFeatureCount}), torch::empty({samples, frames, kFeatureCount}),
               torch::empty({samples, frames}, torch::kInt64)};
  const Tensor last = past.slice(1, past.size(1) - by_.kappa).to(torch::kFloat32), uniform = choice.to(torch::kFloat32);
  std::vector<std::vector<Candidate>> first;
  for (int64_t i = 0; i < past.size(0); ++i) first.push_back(candidates(last[i]));
  const auto of_sample = [&](int64_t s) -> const std::vector<Candidate>& {
    return first[first.size() == 1 ? 0 : static_cast<size_t>(s)];
  };
  std::vector<Candidate> now(static_cast<size_t>(samples));
  const auto length = [&](const Candidate& c) { return motions_[static_cast<size_t>(c.motion)].features.size(0); };
  const auto* u = uniform.contiguous().data_ptr<float>();
  for (int64_t t = 0; t < frames; ++t) {
    Tensor label_scores;
    for (int64_t s = 0; s < samples; ++s) {
      Candidate& at = now[static_cast<size_t>(s)];
      if (t > 0 && ++at.frame < length(at)) continue;
      if (scores && !label_scores.defined()) label_scores = scores().to(torch::kFloat32).contiguous();
      const std::vector<Candidate>& among = t == 0 ? of_sample(s) : at_end_[static_cast<size_t>(at.motion)];
      at = drawn(among, without.empty() ? -1 : without[static_cast<size_t>(s)], u[s * frames + t],
                 label_scores.defined() ? label_scores.data_ptr<float>() + s * label_scores.size(1) : nullptr);
    }
    for (int64_t s = 0; s < samples; ++s)
      out.labels.data_ptr<int64_t>()[s * frames + t] =
          motions_[static_cast<size_t>(now[static_cast<size_t>(s)].motion)]
              .labels.data_ptr<int64_t>()[now[static_cast<size_t>(s)].frame];
    if (seen && t + 1 < frames) seen(out.labels.select(1, t));
    for (int64_t s = 0; s < samples; ++s) {
      const Candidate& at = now[static_cast<size_t>(s)];
      const Motion& m = motions_[static_cast<size_t>(at.motion)];
      std::copy_n(m.features.data_ptr<float>() + at.frame * kFeatureCount, kFeatureCount,
                  out.features.data_ptr<float>() + (s * frames + t) * kFeatureCount);
      std::copy_n(m.changes.data_ptr<float>() + at.frame * kFeatureCount, kFeatureCount,
                  out.changes.data_ptr<float>() + (s * frames + t) * kFeatureCount);
    }
  }
  const int64_t some = std::min(frames, kMeanFrames);
  const Tensor fade =
      (0.5 * (1 + torch::cos(torch::arange(1, some + 1).to(torch::kFloat32) * (M_PI / kMeanFrames)))).unsqueeze(1);
  Followed mean;
  for (int64_t s = 0; s < samples; ++s) {
    if (s == 0 || first.size() > 1 || !without.empty())
      mean = nearest_mean(of_sample(s), without.empty() ? -1 : without[static_cast<size_t>(s)]);
    for (const auto& [all, of] : {std::pair(out.features, mean.features), {out.changes, mean.changes}}) {
      const Tensor own = all[s].slice(0, 0, some);
      own.add_(fade * (of.slice(0, 0, some) - own));
    }
  }
  return out;
}

}  // namespace inhabit::anticipate
