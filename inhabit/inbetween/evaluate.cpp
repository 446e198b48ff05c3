#include "inhabit/inbetween/evaluate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <numeric>
#include <optional>

#include "inhabit/body/body_model.h"
#include "inhabit/body/fit.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/inbetween/features.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/window_scores.h"
#include "inhabit/math/random.h"
#include "inhabit/metrics/bootstrap.h"
#include "inhabit/metrics/frechet.h"
#include "inhabit/nn/one_blas_thread.h"
#include "inhabit/nn/parallel_chunks.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr int64_t kResamples = 1000, kFidResamples = 200, kHalves = 20;

/// What the measures are called in a row; in the order of Measure.
constexpr std::array<Score Scores::*, kMeasures> kScores = {&Scores::skating,
                                                            &Scores::jerk,
                                                            &Scores::jerk_ratio,
                                                            &Scores::acceleration,
                                                            &Scores::key_error,
                                                            &Scores::error,
                                                            &Scores::apart,
                                                            &Scores::frame_ratio,
                                                            &Scores::vertex_ratio,
                                                            &Scores::penetration,
                                                            &Scores::exact_frames,
                                                            &Scores::exact_vertices,
                                                            &Scores::exact_depth,
                                                            &Scores::close_frame_ratio,
                                                            &Scores::close_vertex_ratio,
                                                            &Scores::close_penetration,
                                                            &Scores::upright_frames,
                                                            &Scores::upright_vertices,
                                                            &Scores::upright_depth};

/// A row while it is measured: of each run and window.
struct Row {
  const Method* method;  // none: the real motion
  std::string name, keyframes;
  std::vector<std::vector<WindowScores>> runs;
  std::vector<std::vector<Tensor>> features;             // (64) each
  std::array<std::vector<double>, kMeasures> resampled;  // statistics of resamples of windows
  std::vector<double> resampled_fid;
};

/// The window's motion with joints where its poses put them, and a shape for its skin.
Clip posed_truth(const Window& window) {
  const Clip& truth = window.truth;
  validate(truth, window.name);
  if (!truth.rotations.defined() || !truth.trans.defined() || truth.skeleton.size() != kStandardJoints)
    throw Error(window.name, "has no rotations on the standard skeleton");
  Clip out = truth;
  out.joints = joint_positions(truth.skeleton, truth.rotations, truth.trans);
  if (!out.betas.defined()) out.betas = fit_shape(builtin_body(), truth.joints);
  return out;
}

/// What a method made of a window, checked; with the truth's shape, so that every method moves the same body.
Clip filled(const Method& method, const FillTask& task, uint64_t seed) {
  Clip out = method.run(task, seed);
  const std::string subject = method.name + " on " + task.window.name;
  validate(out, subject);
  if (out.frames() != task.window.truth.frames() || out.skeleton.size() != kStandardJoints || !out.rotations.defined())
    throw Error(subject, "gives another number of frames or joints, or no rotations");
  out.betas = task.window.truth.betas;
  return out;
}

/// Measures windows: rows are filled by all threads at once, each window by one.
class Measuring {
 public:
  Measuring(const std::vector<Window>& windows, MotionAutoencoder features, const Evaluation& options,
            std::vector<Row>& rows)
      : windows_(windows), features_(std::move(features)), options_(options), rows_(rows) {
    for (Row& row : rows_) {
      for (auto& run : row.runs) run.resize(windows.size());
      for (auto& run : row.features) run.resize(windows.size());
    }
    close_.resize(windows.size());
    upright_.resize(windows.size());
    // Windows of one scene after the other share its distance field.
    for (size_t w = 0; w < windows.size(); ++w) {
      if (w == 0 || windows[w].scene != windows[w - 1].scene) first_.push_back(w);
      group_of_.push_back(static_cast<int64_t>(first_.size()) - 1);
      for (const Row& row : rows_)
        if (row.method != nullptr && options.parts.shard().has(group_of_.back()))
          fills_ += static_cast<int64_t>(row.runs.size());
    }
    first_.push_back(windows.size());
  }

  void run() {
    const auto together = [&](int64_t g) {
      const torch::NoGradGuard no_gradients;
      if (!options_.parts.shard().has(g)) return;
      const auto at = static_cast<size_t>(g);
      const CollisionMeter meter(builtin_body(), windows_[first_[at]].scene ? *windows_[first_[at]].scene : Scene{});
      for (size_t w = first_[at]; w < first_[at + 1]; ++w) measure_window(w, meter);
    };
    const auto groups = static_cast<int64_t>(first_.size()) - 1;
    if (options_.parallel) return nn::parallel_chunks(groups, together);
    for (int64_t g = 0; g < groups; ++g) together(g);
  }

  /// With what other parts measured; false where some are still to come.
  bool complete() {
    if (options_.parts.shard().is_all()) return true;
    const auto windows = static_cast<int64_t>(windows_.size());
    int64_t runs = 0;
    for (const Row& row : rows_) runs += static_cast<int64_t>(row.runs.size());
    const bool featured = !rows_.front().features.empty();
    std::map<std::string, Tensor> all = {
        {"scores", torch::zeros({windows, runs, 2, static_cast<int64_t>(kMeasures)}, torch::kDouble)},
        {"features", torch::zeros({windows, featured ? runs : 0, kMotionFeatures})},
        {"frames", torch::zeros({windows, 2}, torch::kInt64)}};
    each_run(all, [&](size_t w, WindowScores& scores, double* packed, Tensor* features, const Tensor& row) {
      std::copy(scores.sum.begin(), scores.sum.end(), packed);
      std::copy(scores.weight.begin(), scores.weight.end(), packed + kMeasures);
      if (features != nullptr && options_.parts.shard().has(group_of_[w])) row.copy_(*features);
    });
    int64_t* frames = all["frames"].data_ptr<int64_t>();
    for (size_t w = 0; w < windows_.size(); ++w) {
      frames[2 * w] = close_[w];
      frames[2 * w + 1] = upright_[w];
    }
    if (!options_.parts.complete(group_of_, all)) return false;
    each_run(all, [&](size_t, WindowScores& scores, const double* packed, Tensor* features, const Tensor& row) {
      std::copy_n(packed, kMeasures, scores.sum.begin());
      std::copy_n(packed + kMeasures, kMeasures, scores.weight.begin());
      if (features != nullptr) *features = row.clone();
    });
    frames = all["frames"].data_ptr<int64_t>();
    for (size_t w = 0; w < windows_.size(); ++w) {
      close_[w] = frames[2 * w];
      upright_[w] = frames[2 * w + 1];
    }
    return true;
  }

  int64_t close_frames() const { return std::accumulate(close_.begin(), close_.end(), int64_t{0}); }
  int64_t upright_frames() const { return std::accumulate(upright_.begin(), upright_.end(), int64_t{0}); }

 private:
  void measure_window(size_t w, const CollisionMeter& meter) {
    Window window = windows_[w];
    window.truth = posed_truth(windows_[w]);
    Compared with{window.truth, options_.truth, {0}, options_.key_joints, {}, {}};
    if (options_.truth) {
      with.close = meter.near_frames(window.truth, kCloseProximity);
      with.upright = with.close & ~sitting_frames(window.truth);
      close_[w] = with.close.sum().item<int64_t>();
      upright_[w] = with.upright.sum().item<int64_t>();
    }
    for (Row& row : rows_) {
      std::vector<Tensor> joints;  // of the runs
      for (size_t r = 0; r < row.runs.size(); ++r) {
        if (row.method == nullptr) {
          with.keys = {0};
          score(row, r, w, window.truth, with, meter);
          continue;
        }
        // Streams of their own for noise, key frames and the method.
        const uint64_t seed = item_seed(item_seed(options_.seed, r), w);
        window.conditioning = noisy_keys(window.truth, options_.noise, item_seed(seed, 0));
        const std::string& chosen = row.keyframes.empty() ? options_.keyframes.front() : row.keyframes;
        with.keys = key_frames(chosen, window.truth.frames(), item_seed(seed, 1));
        const FillTask task{window, with.keys, options_.key_joints, options_.noise};
        const Clip clip = filled(*row.method, task, item_seed(seed, 2));
        score(row, r, w, clip, with, meter);
        joints.push_back(clip.joints);
        const std::lock_guard<std::mutex> lock(mutex_);
        ++done_;
        if (options_.progress) options_.progress(done_, fills_);
      }
      for (size_t r = 0; r < joints.size(); ++r)
        for (size_t other = 0; other < joints.size(); ++other) {
          if (other == r) continue;
          row.runs[r][w].sum[kApart] += (joints[r] - joints[other]).norm(2, {2}).mean().item<double>() * 1000;
          row.runs[r][w].weight[kApart] += 1;
        }
    }
  }

  void score(Row& row, size_t r, size_t w, const Clip& clip, const Compared& with, const CollisionMeter& meter) {
    row.runs[r][w] = window_scores(clip, with, meter, options_.tolerance);
    if (row.features.empty()) return;
    const std::lock_guard<std::mutex> lock(mutex_);
    row.features[r][w] = motion_features(features_, clip.joints.unsqueeze(0))[0];
  }

  /// Calls visit(window, its scores, their numbers in `all`, its features or null, their row in `all`) for every run of
  /// every row.
  template <class Visit>
  void each_run(const std::map<std::string, Tensor>& all, const Visit& visit) {
    double* packed = all.at("scores").data_ptr<double>();
    for (size_t w = 0; w < windows_.size(); ++w) {
      int64_t run = 0;
      for (Row& row : rows_)
        for (size_t r = 0; r < row.runs.size(); ++r, ++run, packed += 2 * kMeasures) {
          const bool featured = !row.features.empty();
          visit(w, row.runs[r][w], packed, featured ? &row.features[r][w] : nullptr,
                featured ? all.at("features")[static_cast<int64_t>(w)][run] : Tensor());
        }
    }
  }

  const std::vector<Window>& windows_;
  MotionAutoencoder features_;
  const Evaluation& options_;
  std::vector<Row>& rows_;
  std::vector<size_t> first_;      // window of each group, then one past the last
  std::vector<int64_t> group_of_;  // of each window
  std::vector<int64_t> close_, upright_;
  std::mutex mutex_;
  int64_t done_ = 0, fills_ = 0;
};

/// Means of a row and their intervals; keeps what the resamples give.
void estimate_measures(Row& row, const Tensor& counts, Scores& out) {
  const size_t windows = row.runs.front().size();
  for (size_t m = 0; m < kMeasures; ++m) {
    Tensor sums = torch::zeros({static_cast<int64_t>(windows)}, torch::kDouble), weights = torch::zeros_like(sums);
    std::vector<double> of_runs;
    for (const auto& run : row.runs) {
      double sum = 0, weight = 0;
      for (size_t w = 0; w < windows; ++w) {
        sums.data_ptr<double>()[w] += run[w].sum[m];
        weights.data_ptr<double>()[w] += run[w].weight[m];
        sum += run[w].sum[m];
        weight += run[w].weight[m];
      }
      of_runs.push_back(weight > 0 ? sum / weight : kNone);
    }
    const Estimate over_runs = estimate(of_runs);
    row.resampled[m] = resampled_ratios(sums, weights, counts);
    out.*kScores[m] = {over_runs.mean, half_interval(row.resampled[m]), over_runs.interval, kNone, 0};
  }
}

/// Frechet distances of all rows from the first, the real motion.
class Distances {
 public:
  Distances(const std::vector<Row>& rows, int64_t windows, uint64_t seed) : windows_(windows), seed_(seed) {
    real_ = frechet_reference(torch::stack(rows.front().features.front()));
    counts_ = bootstrap_counts(windows, kFidResamples, item_seed(seed, 1));
    resampled_.resize(kFidResamples);
    for (int64_t r = 0; r < kFidResamples; ++r)
      resampled_[static_cast<size_t>(r)] = feature_gaussian(real_.features, counts_[r]);
  }
  int64_t dimensions() const { return real_.dimensions(); }

  /// Random halves of the real motion against each other.
  Score of_halves() const {
    if (windows_ < 4) return {};
    std::vector<double> distances;
    std::mt19937_64 random(item_seed(seed_, 2));
    std::vector<int64_t> order(static_cast<size_t>(windows_));
    std::iota(order.begin(), order.end(), 0);
    for (int64_t split = 0; split < kHalves; ++split) {
      for (size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[random() % (i + 1)]);
      const Tensor at = torch::tensor(order);
      const auto half = [&](int64_t from, int64_t to) {
        return feature_gaussian(real_.features.index_select(0, at.slice(0, from, to)));
      };
      distances.push_back(frechet_distance(half(0, windows_ / 2), half(windows_ / 2, windows_)));
    }
    return {estimate(distances).mean, half_interval(distances), 0, kNone, 0};
  }

  /// Of a row: the mean over runs; its resamples pool the runs.
  Score of(Row& row) const {
    std::vector<Tensor> runs;
    std::vector<double> of_runs;
    for (const auto& run : row.features) {
      runs.push_back(real_.along(torch::stack(run)));
      of_runs.push_back(frechet_distance(real_.gaussian, feature_gaussian(runs.back())));
    }
    const Tensor all = torch::cat(runs);
    row.resampled_fid.resize(kFidResamples);
    nn::parallel_chunks(kFidResamples, [&](int64_t r) {
      const Tensor counts = counts_[r].repeat({static_cast<int64_t>(runs.size())});
      row.resampled_fid[static_cast<size_t>(r)] =
          frechet_distance(resampled_[static_cast<size_t>(r)], feature_gaussian(all, counts));
    });
    const Estimate over_runs = estimate(of_runs);
    return {over_runs.mean, half_interval(row.resampled_fid), over_runs.interval, kNone, 0};
  }

 private:
  int64_t windows_;
  uint64_t seed_;
  FrechetReference real_;
  Tensor counts_;
  std::vector<FeatureGaussian> resampled_;
};

void set_difference(Score& score, const Score& from, const std::vector<double>& own,
                    const std::vector<double>& others) {
  score.difference = score.mean - from.mean;
  std::vector<double> differences(std::min(own.size(), others.size()));
  for (size_t i = 0; i < differences.size(); ++i) differences[i] = own[i] - others[i];
  score.difference_interval = half_interval(differences);
}

/// Differences of every row from the one called `against` with the same keys, or the first one called so.
void set_differences(const std::vector<Row>& rows, const std::string& against, std::vector<Scores>& scores) {
  for (size_t i = 0; i < rows.size(); ++i) {
    size_t found = rows.size();
    for (size_t k = 0; k < rows.size(); ++k)
      if (rows[k].name == against && (found == rows.size() || rows[k].keyframes == rows[i].keyframes)) found = k;
    if (found == rows.size()) throw Error("against '" + against + "'", "is the name of no row");
    for (size_t m = 0; m < kMeasures; ++m)
      set_difference(scores[i].*kScores[m], scores[found].*kScores[m], rows[i].resampled[m], rows[found].resampled[m]);
    // The distance from the real motion to itself is 0 in every resample; its row says what halves have.
    if (found != 0 && i != 0)
      set_difference(scores[i].fid, scores[found].fid, rows[i].resampled_fid, rows[found].resampled_fid);
  }
}

void check(const std::vector<Window>& windows, const Evaluation& options) {
  if (windows.empty()) throw Error("evaluation", "has no window");
  if (options.keyframes.empty()) throw Error("evaluation", "has no choice of key frames");
  if (options.seeds < 1) throw Error("seeds", "must be at least 1");
}

}  // namespace

Clip noisy_keys(const Clip& clip, double level, uint64_t seed) {
  if (!(level >= 0 && level <= 90)) throw Error("noise level", "is not from 0 to 90 degrees and centimetres");
  if (level == 0) return clip;
  std::mt19937_64 random(seed);
  return clip_of_features(noisy_features(clip_features(clip), clip.skeleton.offsets, level, random), clip);
}

Table evaluate(const std::vector<Window>& windows, const std::vector<Method>& methods, MotionAutoencoder features,
               const Evaluation& options) {
  const torch::NoGradGuard no_gradients;
  const nn::OneBlasThread one_blas_thread;
  check(windows, options);
  const bool comparable =
      options.truth && !features.is_empty() && windows.size() > 1 &&
      std::all_of(windows.begin(), windows.end(), [](const auto& w) { return w.truth.frames() == kFeatureFrames; });

  const Method input = {"noisy input", [](const FillTask& task, uint64_t) { return task.window.conditioning; }};
  std::vector<Row> rows;
  const auto add = [&](const Method* method, const std::string& name, const std::string& keyframes, int64_t runs) {
    const auto count = static_cast<size_t>(runs);
    rows.push_back({method,
                    name,
                    keyframes,
                    std::vector<std::vector<WindowScores>>(count),
                    std::vector<std::vector<Tensor>>(comparable ? count : 0),
                    {},
                    {}});
  };
  add(nullptr, options.truth ? "real motion" : "recording", "", 1);
  if (options.noise > 0) add(&input, input.name, "", options.seeds);
  for (const std::string& keyframes : options.keyframes)
    for (const Method& method : methods) {
      const bool varies = method.random || options.noise > 0 || keyframes.rfind("random:", 0) == 0;
      add(&method, method.name, keyframes, varies ? options.seeds : 1);
    }

  Measuring measuring(windows, features, options, rows);
  measuring.run();
  Table table;
  if (!measuring.complete()) return table;
  table.windows = static_cast<int64_t>(windows.size());
  table.close_frames = measuring.close_frames();
  table.upright_frames = measuring.upright_frames();
  table.noise = options.noise;
  table.truth = options.truth;
  std::optional<Distances> distances;
  if (comparable) distances.emplace(rows, table.windows, options.seed);
  if (distances) table.dimensions = distances->dimensions();
  const Tensor counts = bootstrap_counts(table.windows, kResamples, item_seed(options.seed, 0));
  for (Row& row : rows) {
    Scores scores;
    scores.method = row.name;
    scores.keyframes = row.keyframes;
    scores.runs = static_cast<int64_t>(row.runs.size());
    estimate_measures(row, counts, scores);
    if (distances) scores.fid = row.method == nullptr ? distances->of_halves() : distances->of(row);
    table.rows.push_back(scores);
  }
  table.against =
      options.against.empty() ? methods.empty() ? rows.front().name : methods.front().name : options.against;
  set_differences(rows, table.against, table.rows);
  return table;
}

}  // namespace inhabit::inbetween
