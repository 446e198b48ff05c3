#include "inhabit/anticipate/motion_memory.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "inhabit/anticipate/features.h"
#include "inhabit/anticipate/sample.h"
#include "inhabit/error.h"
#include "inhabit/interruption.h"
#include "inhabit/metrics/motion_words.h"
#include "inhabit/metrics/ndms.h"

namespace inhabit::anticipate {

using torch::Tensor;

namespace {

constexpr int64_t kLeastFollowed = 10;   // frames that must follow a place, so that something is remembered
constexpr int64_t kMostPlaces = 25'000;  // of one side: words of twice as many take 60 MB
constexpr int64_t kLeaveEvery = 25;      // frames of a recording between the places where another may be chosen
constexpr int64_t kLeastStay = 50;       // frames that one is followed at least, unless it ends
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
}

std::vector<MotionMemory::Candidate> MotionMemory::candidates(const Tensor& seen,
                                                              const std::vector<int64_t>& without) const {
  const Tensor word = words_of_features(seen.slice(0, seen.size(0) - by_.kappa), by_.kappa)[0].contiguous();
  Tensor products = torch::empty({words_.size(0)});
  // Not words_.mv(word): whoever draws on all cores would wait for OpenBLAS's threads.
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::Map<Eigen::VectorXf>(products.data_ptr<float>(), words_.size(0)).noalias() =
      Eigen::Map<const Rows>(words_.data_ptr<float>(), words_.size(0), words_.size(1)) *
      Eigen::Map<const Eigen::VectorXf>(word.data_ptr<float>(), word.size(0));
  const Tensor squared = (squared_ - 2 * products + word.square().sum()).clamp_min(0);
  const Tensor distance = (squared / (static_cast<double>(word.size(0)) / 3)).sqrt();
  const float *d = distance.data_ptr<float>(), *typical = typical_.data_ptr<float>();
  std::vector<int64_t> followed;  // motions
  double nearest = std::numeric_limits<double>::infinity();
  for (size_t m = 0; m < motions_.size(); ++m) {
    const Motion& motion = motions_[m];
    if (motion.words == 0 || std::count(without.begin(), without.end(), static_cast<int64_t>(m) / 2) > 0) continue;
    followed.push_back(static_cast<int64_t>(m));
    nearest = std::min<double>(nearest, *std::min_element(d + motion.first_word, d + motion.first_word + motion.words));
  }
  if (followed.empty()) return candidates(seen, {});  // nothing else is remembered
  std::vector<Candidate> out;
  for (const int64_t m : followed) {
    const Motion& motion = motions_[static_cast<size_t>(m)];
    Candidate best{m, -1, 0, -1, 0};
    for (int64_t i = 0; i < motion.words; ++i) {
      const int64_t row = motion.first_word + i, frame = by_.kappa + i * stride_;
      const double score = -d[row] / by_.distance + by_.typical * typical[row];
      if (d[row] <= nearest + by_.within && (best.frame < 0 || score > best.score)) {
        best.frame = frame;
        best.score = score;
      }
      if (best.nearest < 0 || d[row] < best.distance) {
        best.nearest = frame;
        best.distance = d[row];
      }
    }
    if (best.frame < 0) best = {m, best.nearest, -std::numeric_limits<double>::infinity(), best.nearest, best.distance};
    out.push_back(best);
  }
  return out;
}

Followed MotionMemory::nearest_mean(std::vector<Candidate> among) const {
  std::stable_sort(among.begin(), among.end(),
                   [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
  among.resize(std::min(among.size(), kMeanOf));
  Followed out{torch::zeros({kMeanFrames, kFeatureCount}), torch::zeros({kMeanFrames, kFeatureCount}), {}};
  double sum = 0;
  for (const Candidate& c : among) {
    const double weight = std::exp((among.front().distance - c.distance) / kMeanDistance);
    const Tensor& features = motions_[static_cast<size_t>(c.motion)].features;
    // A recording that ends sooner stays as it is then.
    const Tensor rows = torch::arange(c.nearest - 1, c.nearest + kMeanFrames).clamp_max(features.size(0) - 1);
    const Tensor some = features.index_select(0, rows);
    out.features += weight * some.slice(0, 1);
    out.changes += weight * (some.slice(0, 1) - some.slice(0, 0, -1));
    sum += weight;
  }
  out.features /= sum;
  out.changes /= sum;
  return out;
}

const MotionMemory::Candidate& MotionMemory::drawn(const std::vector<Candidate>& among, double uniform,
                                                   const float* label_scores) const {
  std::vector<double> weight;
  for (const Candidate& c : among) {
    const Tensor& labels = motions_[static_cast<size_t>(c.motion)].labels;
    weight.push_back(c.score + (label_scores != nullptr ? label_scores[labels.data_ptr<int64_t>()[c.frame]] : 0));
  }
  const double highest = *std::max_element(weight.begin(), weight.end());
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

const std::vector<MotionMemory::Candidate>& MotionMemory::leaving(int64_t motion, int64_t frame,
                                                                  int64_t without) const {
  const std::lock_guard<std::mutex> lock(leaving_mutex_);
  const auto [at, isnew] = leaving_.try_emplace({motion, frame, without});
  if (isnew)
    at->second = candidates(motions_[static_cast<size_t>(motion)].features.slice(0, 0, frame), {motion / 2, without});
  return at->second;
}

void MotionMemory::copy(const Position& at, float* features, float* changes) const {
  const Tensor& all = motions_[static_cast<size_t>(at.motion)].features;
  const auto between = [&](double frame, int64_t i) {
    const double before = std::floor(frame), weight = frame - before;
    const float* row = all.data_ptr<float>() + static_cast<int64_t>(before) * kFeatureCount + i;
    return weight > 0 ? (1 - weight) * row[0] + weight * row[kFeatureCount] : static_cast<double>(row[0]);
  };
  for (int64_t i = 0; i < kFeatureCount; ++i) {
    // The root's steps and its rotation are speeds themselves.
    const double scale = i >= kPoseFeatures && i < kPoseFeatures + 3 ? at.speed : 1, now = between(at.frame, i);
    features[i] = static_cast<float>(scale * now);
    changes[i] = static_cast<float>(scale * (now - between(at.frame - at.speed, i)));
  }
}

Followed MotionMemory::follow(const Tensor& past, const Tensor& choice, const std::vector<int64_t>& without,
                              const LabelScores& scores, const LabelsSeen& seen) const {
  const torch::NoGradGuard no_gradients;
  const int64_t samples = choice.size(0), frames = choice.size(1);
  Followed out{torch::empty({samples, frames, kFeatureCount}), torch::empty({samples, frames, kFeatureCount}),
               torch::empty({samples, frames}, torch::kInt64)};
  const Tensor last = past.slice(1, past.size(1) - by_.kappa).to(torch::kFloat32),
               uniform = choice.to(torch::kFloat32).contiguous();
  const auto own = [&](int64_t s) { return without.empty() ? -1 : without[static_cast<size_t>(s)]; };
  const bool alike = past.size(0) == 1 && without.empty();
  std::vector<std::vector<Candidate>> first;
  for (int64_t s = 0; s < (alike ? 1 : samples); ++s)
    first.push_back(candidates(last[past.size(0) == 1 ? 0 : s], {own(s)}));
  const auto at_first = [&](int64_t s) -> const std::vector<Candidate>& {
    return first[alike ? 0 : static_cast<size_t>(s)];
  };
  std::vector<Position> now(static_cast<size_t>(samples));
  /// The candidates among which the next frame of a future is; null: it follows on.
  const auto choices = [&](Position& at, int64_t s, int64_t t, double chance) -> const std::vector<Candidate>* {
    const int64_t length = motions_[static_cast<size_t>(at.motion)].features.size(0);
    const double before = at.frame;
    at.frame += at.speed;
    if (at.frame > static_cast<double>(length - 1)) return &leaving(at.motion, length, own(s));
    const auto point = static_cast<int64_t>(at.frame) / kLeaveEvery;
    if (by_.stay <= 0 || point == static_cast<int64_t>(before) / kLeaveEvery || chance * by_.stay >= kLeaveEvery ||
        t - at.since < kLeastStay || point * kLeaveEvery < by_.kappa)
      return nullptr;
    return &leaving(at.motion, point * kLeaveEvery, own(s));
  };
  for (int64_t t = 0; t < frames; ++t) {
    interruption_point();
    Tensor label_scores;
    auto* label = out.labels.data_ptr<int64_t>() + t;
    for (int64_t s = 0; s < samples; ++s) {
      Position& at = now[static_cast<size_t>(s)];
      const int64_t row = s * frames + t;
      const float* u = uniform.data_ptr<float>() + 3 * row;
      if (const auto* among = t == 0 ? &at_first(s) : choices(at, s, t, u[2])) {
        if (scores && !label_scores.defined()) label_scores = scores().to(torch::kFloat32).contiguous();
        const float* of_labels =
            label_scores.defined() ? label_scores.data_ptr<float>() + s * label_scores.size(1) : nullptr;
        const Candidate& c = drawn(*among, u[0], of_labels);
        const double speed = 1 + by_.warp * (2.0 * u[1] - 1);
        at = {c.motion, static_cast<double>(c.frame) - 1 + speed, speed, t};
      }
      copy(at, out.features.data_ptr<float>() + row * kFeatureCount,
           out.changes.data_ptr<float>() + row * kFeatureCount);
      label[s * frames] =
          motions_[static_cast<size_t>(at.motion)].labels.data_ptr<int64_t>()[static_cast<int64_t>(at.frame)];
    }
    if (seen && t + 1 < frames) seen(out.labels.select(1, t));
  }
  const int64_t some = std::min(frames, kMeanFrames);
  const Tensor time = torch::arange(1, some + 1).to(torch::kFloat32) * (M_PI / kMeanFrames),
               weight = (0.5 * (1 + torch::cos(time))).unsqueeze(1);
  Followed mean;
  for (int64_t s = 0; s < samples; ++s) {
    if (s == 0 || !alike) mean = nearest_mean(at_first(s));
    for (const auto& [all, of] : {std::pair(out.features, mean.features), {out.changes, mean.changes}}) {
      const Tensor drawn_one = all[s].slice(0, 0, some);
      drawn_one.add_(weight * (of.slice(0, 0, some) - drawn_one));
    }
  }
  return out;
}

}  // namespace inhabit::anticipate
