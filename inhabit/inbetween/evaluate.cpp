#include "inhabit/inbetween/evaluate.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "inhabit/body/body_model.h"
#include "inhabit/body/fit.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/inbetween/features.h"
#include "inhabit/inbetween/interpolate.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/math/random.h"
#include "inhabit/metrics/collision.h"
#include "inhabit/metrics/dynamics.h"
#include "inhabit/metrics/foot_skating.h"
#include "inhabit/metrics/frechet.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kCloseProximity = 0.08;  // metres (4.1)

/// Sums over windows of one run of a row.
struct Run {
  int64_t windows = 0, close_frames = 0, close_windows = 0;
  double skating = 0, jerk = 0, key_error = 0, error = 0, frames = 0, vertices = 0, penetration = 0;
  double close_colliding = 0, close_vertices = 0, close_penetration = 0;  // the first two over close frames
  std::vector<Tensor> features;                                           // (64) each

  /// @param given joints that the keys between the ends give; empty: all of every key
  void add(const Clip& clip, const Clip& truth, const std::vector<int64_t>& keys, const std::vector<int64_t>& given,
           const CollisionMeter& meter, const Tensor& close) {
    ++windows;
    skating += foot_skating(clip).fraction();
    jerk += dynamics(clip).jerk;
    const Tensor distance = (clip.joints - truth.joints).to(torch::kDouble).norm(2, {2}) * 1000;  // (T, J)
    Tensor at_keys = distance.index_select(0, torch::tensor(keys));
    if (!given.empty()) at_keys = at_keys.slice(0, 1, -1).index_select(1, torch::tensor(given));
    if (at_keys.numel() > 0) key_error += at_keys.mean().item<double>();
    error += distance.mean().item<double>();
    const Collision collision = meter.measure(clip);
    frames += collision.frame_ratio();
    vertices += collision.vertex_ratio();
    penetration += collision.penetration() * 1000;
    const auto count = close.sum().item<int64_t>();
    if (count == 0) return;
    ++close_windows;
    close_frames += count;
    close_colliding += collision.frame_ratio(close) * static_cast<double>(count);
    close_vertices += collision.vertex_ratio(close) * static_cast<double>(count);
    close_penetration += collision.penetration(close) * 1000;
  }
};

double ratio(double sum, int64_t count) { return count > 0 ? sum / static_cast<double>(count) : kNone; }

Scores scores_of(const std::string& method, const std::string& keyframes, const std::vector<Run>& runs,
                 const FeatureGaussian* real, double real_jerk) {
  Scores out;
  out.method = method;
  out.keyframes = keyframes;
  out.runs = static_cast<int64_t>(runs.size());
  const auto over = [&](const auto& value) {
    std::vector<double> values(runs.size());
    std::transform(runs.begin(), runs.end(), values.begin(), value);
    return estimate(values);
  };
  const auto mean = [&](double Run::*sum) { return over([&](const Run& r) { return ratio(r.*sum, r.windows); }); };
  out.fid = over([&](const Run& r) {
    return real != nullptr ? frechet_distance(*real, feature_gaussian(torch::stack(r.features))) : kNone;
  });
  out.skating = mean(&Run::skating);
  out.jerk = mean(&Run::jerk);
  out.jerk_ratio = over([&](const Run& r) { return real_jerk > 0 ? ratio(r.jerk, r.windows) / real_jerk : kNone; });
  out.key_error = mean(&Run::key_error);
  out.error = mean(&Run::error);
  out.frame_ratio = mean(&Run::frames);
  out.vertex_ratio = mean(&Run::vertices);
  out.penetration = mean(&Run::penetration);
  out.close_frame_ratio = over([&](const Run& r) { return ratio(r.close_colliding, r.close_frames); });
  out.close_vertex_ratio = over([&](const Run& r) { return ratio(r.close_vertices, r.close_frames); });
  out.close_penetration = over([&](const Run& r) { return ratio(r.close_penetration, r.close_windows); });
  return out;
}

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
Clip filled(const Method& method, const Window& window, const std::vector<int64_t>& keys, uint64_t seed) {
  Clip out = method.run({window, keys}, seed);
  const std::string subject = method.name + " on " + window.name;
  validate(out, subject);
  if (out.frames() != window.truth.frames() || out.skeleton.size() != kStandardJoints || !out.rotations.defined())
    throw Error(subject, "gives another number of frames or joints, or no rotations");
  out.betas = window.truth.betas;
  return out;
}

/// What a model lacks, as rows of the paper's tables are called.
std::string row_name(const Config& c) {
  std::string without;
  if (!c.global_scene && !c.local_scene) {
    without = "scene";
  } else if (!c.global_scene) {
    without = "global feature";
  } else if (!c.local_scene) {
    without = "local feature";
  }
  if (!c.body_shape) without += (without.empty() ? "" : ", ") + std::string("body shape");
  std::string name = without.empty() ? "ours" : "w/o " + without;
  if (c.t_star > 0) name += " (T* = " + std::to_string(c.t_star) + ")";
  return name;
}

struct Column {
  const char* title;
  const char* key;
  Estimate Scores::*value;
  int decimals;
};

constexpr std::array<Column, 12> kColumns = {
    {{"FID", "fid", &Scores::fid, 3},
     {"Foot Skating", "foot_skating", &Scores::skating, 3},
     {"Jerk (m/s3)", "jerk", &Scores::jerk, 1},
     {"Jerk / real", "jerk_ratio", &Scores::jerk_ratio, 2},
     {"MPJE Key (mm)", "mpje_key_mm", &Scores::key_error, 1},
     {"MPJE All (mm)", "mpje_all_mm", &Scores::error, 1},
     {"Coll. Frames", "collision_frame_ratio", &Scores::frame_ratio, 4},
     {"Coll. Vertices", "collision_vertex_ratio", &Scores::vertex_ratio, 5},
     {"Pene. Max (mm)", "penetration_max_mm", &Scores::penetration, 1},
     {"Coll. Frames", "close_collision_frame_ratio", &Scores::close_frame_ratio, 4},
     {"Coll. Vertices", "close_collision_vertex_ratio", &Scores::close_vertex_ratio, 5},
     {"Pene. Max (mm)", "close_penetration_max_mm", &Scores::close_penetration, 1}}};

/// Indices of kColumns.
std::vector<size_t> columns_of(Layout layout) {
  switch (layout) {
    case Layout::methods:
      return {0, 1, 2, 3, 4, 5, 6, 8};
    case Layout::close:
      return {9, 10, 11};
    case Layout::keys:
      return {0, 2, 5};
    case Layout::settings:
      return {0, 2, 5, 6, 8};
    case Layout::seeds:
      return {0, 2, 5, 6};
  }
  return {};
}

}  // namespace

Method model_method(const std::shared_ptr<const SceneInbetweener>& model, const Options& options) {
  return {row_name(model->config()),
          [model, options](const FillTask& task, uint64_t seed) {
            const Window& w = task.window;
            Options own = options;
            own.keys = task.keys;
            own.seed = seed;
            own.standard = true;
            return model->run(w.given, w.scene ? *w.scene : floor_scene(), own).motion;
          },
          /*random=*/true};
}

std::vector<Method> interpolation_methods() {
  const auto method = [](const char* name, Clip (*interpolate)(const Clip&, const std::vector<int64_t>&)) {
    return Method{name,
                  [interpolate](const FillTask& task, uint64_t) { return interpolate(task.window.given, task.keys); }};
  };
  return {method("linear + slerp", &interpolate_linear), method("cubic spline", &interpolate_spline)};
}

Clip noisy_keys(const Clip& clip, double level, uint64_t seed) {
  if (!(level >= 0 && level <= 90)) throw Error("noise level", "is not from 0 to 90 degrees and centimetres");
  if (level == 0) return clip;
  std::mt19937_64 random(seed);
  return clip_of_features(noisy_features(clip_features(clip), clip.skeleton.offsets, level, random), clip);
}

Table evaluate(const std::vector<Window>& windows, const std::vector<Method>& methods, MotionAutoencoder features,
               const Evaluation& options) {
  const torch::NoGradGuard no_gradients;
  if (windows.empty()) throw Error("evaluation", "has no window");
  if (options.keyframes.empty()) throw Error("evaluation", "has no choice of key frames");
  if (options.seeds < 1) throw Error("seeds", "must be at least 1");
  const bool comparable =
      !features.is_empty() && windows.size() > 1 &&
      std::all_of(windows.begin(), windows.end(), [](const auto& w) { return w.truth.frames() == kFeatureFrames; });

  struct Row {
    const Method* method;
    std::string keyframes;
    std::vector<Run> runs;
  };
  std::vector<Row> rows;
  int64_t fills = 0;
  const Method input = {"noisy input", [](const FillTask& task, uint64_t) { return task.window.given; }};
  if (options.noise > 0) {
    rows.push_back({&input, "", std::vector<Run>(static_cast<size_t>(options.seeds))});
    fills += options.seeds * static_cast<int64_t>(windows.size());
  }
  for (const std::string& keyframes : options.keyframes)
    for (const Method& method : methods) {
      const bool varies = method.random || options.noise > 0 || keyframes.rfind("random:", 0) == 0;
      rows.push_back({&method, keyframes, std::vector<Run>(static_cast<size_t>(varies ? options.seeds : 1))});
      fills += static_cast<int64_t>(rows.back().runs.size() * windows.size());
    }

  Run real;
  const Scene nothing;
  const Scene* met = nullptr;
  std::optional<CollisionMeter> meter;
  const auto measure = [&](Run& run, const Clip& clip, const Window& window, const std::vector<int64_t>& keys,
                           const Tensor& close) {
    run.add(clip, window.truth, keys, options.key_joints, *meter, close);
    if (comparable) run.features.push_back(motion_features(features, clip.joints.unsqueeze(0))[0]);
  };
  int64_t done = 0;
  for (size_t w = 0; w < windows.size(); ++w) {
    Window window = windows[w];
    window.truth = posed_truth(windows[w]);
    const Scene* scene = window.scene ? window.scene.get() : &nothing;
    if (!meter || scene != met) meter.emplace(builtin_body(), *(met = scene));
    const Tensor close = meter->near_frames(window.truth, kCloseProximity);
    measure(real, window.truth, window, {0}, close);
    for (Row& row : rows)
      for (size_t r = 0; r < row.runs.size(); ++r) {
        // Streams of their own for noise, key frames and the method.
        const uint64_t seed = item_seed(item_seed(options.seed, r), w);
        window.given = noisy_keys(window.truth, options.noise, item_seed(seed, 0));
        const std::string& chosen = row.keyframes.empty() ? options.keyframes.front() : row.keyframes;
        const std::vector<int64_t> keys = key_frames(chosen, window.truth.frames(), item_seed(seed, 1));
        measure(row.runs[r], filled(*row.method, window, keys, item_seed(seed, 2)), window, keys, close);
        if (options.progress) options.progress(++done, fills);
      }
  }

  Table table;
  table.windows = static_cast<int64_t>(windows.size());
  table.close_frames = real.close_frames;
  table.noise = options.noise;
  FeatureGaussian gaussian;
  if (comparable) gaussian = feature_gaussian(torch::stack(real.features));
  const FeatureGaussian* known = comparable ? &gaussian : nullptr;
  const double jerk = ratio(real.jerk, real.windows);
  table.rows.push_back(scores_of("real motion", "", {real}, known, jerk));
  for (const Row& row : rows) table.rows.push_back(scores_of(row.method->name, row.keyframes, row.runs, known, jerk));
  return table;
}

ScoreTable score_table(const Table& table, Layout layout) {
  std::set<std::string> choices, methods;
  for (const Scores& row : table.rows) {
    if (row.keyframes.empty()) continue;
    choices.insert(row.keyframes);
    methods.insert(row.method);
  }
  const bool one_choice = choices.size() <= 1, one_method = methods.size() <= 1, by_keys = layout == Layout::keys;
  const auto label = [&](const Scores& row) {
    if (row.keyframes.empty()) return row.method;
    if (by_keys && one_method) return row.keyframes;
    return one_choice && !by_keys ? row.method : row.method + ", " + row.keyframes;
  };
  ScoreTable out;
  out.labels = {by_keys && one_method ? "key frames" : "method"};
  const std::vector<size_t> columns = columns_of(layout);
  for (const size_t c : columns) out.columns.push_back({"", kColumns[c].title, kColumns[c].key, kColumns[c].decimals});
  int64_t runs = 1;
  for (const Scores& row : table.rows) {
    out.rows.push_back({{label(row)}, {}});
    for (const size_t c : columns) out.rows.back().cells.push_back(row.*kColumns[c].value);
    runs = std::max(runs, row.runs);
  }
  std::string note = fmt::format("{} windows", table.windows);
  if (layout == Layout::close)
    note += fmt::format(", {} frames closer to the scene than {:.0f} cm", table.close_frames, kCloseProximity * 100);
  if (table.noise > 0) note += fmt::format(", key frames with noise of level {:g}", table.noise);
  out.notes = {note + fmt::format(", {} seed{}", runs, runs == 1 ? "" : "s")};
  return out;
}

std::string table_text(const Table& table, Layout layout) {
  return text_of(score_table(table, layout), layout == Layout::seeds);
}

nlohmann::ordered_json table_json(const Table& table) {
  ScoreTable all;
  all.labels = {"method", "keyframes", "runs"};
  for (const Column& column : kColumns) all.columns.push_back({"", column.title, column.key, column.decimals});
  for (const Scores& row : table.rows) {
    all.rows.push_back({{row.method, row.keyframes, std::to_string(row.runs)}, {}});
    for (const Column& column : kColumns) all.rows.back().cells.push_back(row.*column.value);
  }
  return {{"windows", table.windows},
          {"close_frames", table.close_frames},
          {"noise", table.noise},
          {"rows", rows_json(all, /*intervals=*/true)}};
}

}  // namespace inhabit::inbetween
