#include "inhabit/inbetween/residual_batch.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "inhabit/inbetween/drawn_keys.h"
#include "inhabit/inbetween/foot_contact_net.h"
#include "inhabit/inbetween/learned_detours.h"
#include "inhabit/inbetween/obstacle_detours.h"
#include "inhabit/inbetween/residual_input.h"
#include "inhabit/inbetween/walked_detours.h"
#include "inhabit/math/random.h"

namespace inhabit::inbetween {

using torch::Tensor;

namespace {

constexpr double kSelfConditioned = 0.5;  // fraction of batches that see an earlier prediction
constexpr double kMostNoise = 2.5;        // level of noise on keys
constexpr double kNoisyLast = 0.5;        // fraction of noisy windows whose last key is noisy, too, as in long clips
constexpr int kLookedAt = 6;              // windows, to find one whose baseline is blocked
constexpr float kInside = 0.03F;          // metres that a blocked baseline is inside obstacles
constexpr int kAcross = 8;                // parts of the line from a baseline's root to the true one
constexpr int64_t kScaleWindows = 2000;
constexpr double kPassesBy = 0.4;       // metres that somebody with hanging arms keeps from what is passed
constexpr int64_t kSoonerOrLater = 15;  // frames by which a sample may pass it sooner or later than the truth
constexpr double kTargetWeight = 10;    // of joints that partial keys constrain

struct Example {
  PoseWindow window;
  Baseline baseline;
};

/// Points of the body at every fourth frame that are inside obstacles where the true motion's are not.
bool blocked(const PoseWindow& window, const Baseline& baseline) {
  for (int64_t t = 2; t < window.poses.frames(); t += 4)
    for (const int64_t joint : {0, 4, 5, 9, 12, 20, 21}) {
      const size_t at = Poses::at(t, joint);
      if (window.scene.distance(baseline.poses.joints[at]) < -kInside &&
          window.scene.distance(window.poses.joints[at]) > -kInside)
        return true;
    }
  return false;
}

/// Whether what the truth does beyond the baseline leads through obstacles: they go around on different sides. Seen at
/// every fourth frame from knee to chest.
bool on_other_side(const PoseWindow& window, const Baseline& baseline) {
  for (int64_t t = 2; t < window.poses.frames(); t += 4)
    for (int i = 1; i < kAcross; ++i)
      for (const float height : {0.5F, 0.8F, 1.1F}) {
        const float part = static_cast<float>(i) / kAcross;
        Eigen::Vector3f place = (1 - part) * baseline.poses.root(t) + part * window.poses.root(t);
        place.y() = height;
        if (window.scene.distance(place) < -kInside) return true;
      }
  return false;
}

/// What a window's noisy keys are; those at the ends have no noise, nor have known frames.
KeyNoise draw_noise(const DrawnKeys& keys, const Config& c, std::mt19937_64& random) {
  KeyNoise out;
  out.rate = c.rate;
  if (!chance(random, c.training.noisy)) return out;
  out.level = uniform(random, 0, kMostNoise);
  const Tensor ends = keys.ends.contiguous();
  for (int64_t t = 0; t < ends.size(0); ++t) out.exact.push_back(ends.data_ptr<float>()[t] > 0 ? 1 : 0);
  if (chance(random, kNoisyLast))
    for (size_t t = out.exact.size(); t-- > 1;)
      if (out.exact[t] != 0) {
        out.exact[t] = 0;
        break;
      }
  return out;
}

/// What the keys of a window are read from: the truth, noisy where it is not exact.
Poses key_source(const Poses& truth, const KeyNoise& noise, std::mt19937_64& random) {
  if (noise.level == 0) return truth;
  Poses out = with_noise(truth, noise.level, random);
  for (size_t t = 0; t < noise.exact.size(); ++t)
    if (noise.exact[t] != 0) copy_frame(truth, static_cast<int64_t>(t), out);
  return out;
}

Example find_window(const PoseWindows& data, const Config& c, std::mt19937_64& random) {
  const bool recorded = data.generated().empty() || (!data.recorded().empty() && chance(random, c.training.recorded));
  const std::vector<int64_t>& windows = recorded ? data.recorded() : data.generated();
  const bool around = chance(random, c.training.way_around);
  const int draws = chance(random, c.training.blocked) ? kLookedAt : 1;
  std::optional<Example> first;
  for (int i = 0; i < draws; ++i) {
    const int64_t index = windows[static_cast<size_t>(uniform_int(random, 0, static_cast<int>(windows.size()) - 1))];
    const bool mirrored = chance(random, 0.5);
    const double most = std::log1p(recorded ? c.training.time_warp : 0);
    PoseWindow window = data.window(index, mirrored, most > 0 ? std::exp(uniform(random, -most, most)) : 1);
    const DrawnKeys keys = draw_keys(c.frames, c.partial_keys, draws > 1 ? 1 : c.training.far_keys, random);
    const KeyNoise noise = draw_noise(keys, c, random);
    const Poses key_poses = key_source(window.poses, noise, random);
    Baseline baseline = baseline_of(key_poses, keys.groups, {}, noise);
    const bool taken = draws == 1 || blocked(window, baseline);
    if (around && (taken || i == 0) && chance(random, c.training.walked)) {
      // In use the path is free, and to be kept to: the one that was walked.
      baseline = baseline_of(key_poses, keys.groups, walked_detours(window.poses, keys.groups, window.scene), noise);
    } else if (around && (taken || i == 0)) {
      // In use the path is settled when it is found: a truth on the other side would teach to cut across.
      Baseline detour =
          baseline_of(key_poses, keys.groups, detours_of_poses(key_poses, keys.groups, window.scene), noise);
      if (!on_other_side(window, detour)) baseline = std::move(detour);
    }
    if (taken) return {std::move(window), std::move(baseline)};
    if (i == 0) first = Example{std::move(window), std::move(baseline)};
  }
  return std::move(*first);
}

Example draw_window(const PoseWindows& data, const Config& c, std::mt19937_64& random) {
  Example out = find_window(data, c, random);
  if (!c.along_detours) out.baseline.legs = {};
  return out;
}

ResidualBatch make_batch(const std::vector<Example>& examples, const Config& c, const Tensor& table,
                         std::mt19937_64& random) {
  const torch::NoGradGuard no_gradients;
  ResidualBatch out;
  std::vector<const Baseline*> baselines;
  std::vector<Tensor> residuals, fixed, bones, weights, feet;
  std::vector<float> kept;
  std::vector<int64_t> steps;
  for (const Example& e : examples) {
    baselines.push_back(&e.baseline);
    residuals.push_back(residual_of(e.window.poses, e.baseline));
    kept.push_back(chance(random, c.training.scene_dropout) ? 0.F : 1.F);
    const Tensor fan = kept.back() > 0 ? scene_fan(e.window.scene, e.baseline) : torch::zeros({c.frames, kFanFeatures});
    fixed.push_back(static_features(e.baseline, fan, c.rate));
    bones.push_back(bone_lengths(e.window.poses));
    const Tensor exact = (torch::tensor(e.baseline.noise) == 0).to(torch::kFloat32).unsqueeze(1);
    weights.push_back(1 + (kTargetWeight - 1) * e.baseline.targets.select(2, 3) * exact);
    feet.push_back(foot_contacts(e.window.poses, c.rate));
    const int last = c.diffusion_steps - 1;
    steps.push_back(chance(random, c.training.noisiest) ? uniform_int(random, last - last / 10, last)
                                                        : uniform_int(random, 0, last));
    out.scenes.push_back(e.window.scene);
  }
  out.frames = residual_frames(baselines, table);
  out.open = (out.frames.scale > 0).to(torch::kFloat32);
  out.residual = torch::stack(residuals) / out.frames.scale.clamp_min(1e-6) * out.open;
  out.fixed = torch::stack(fixed);
  out.bones = torch::stack(bones);
  out.weights = torch::stack(weights);
  out.feet = torch::stack(feet);
  out.kept = torch::tensor(kept);
  out.steps = torch::tensor(steps);
  auto generator = at::detail::createCPUGenerator(random());
  out.noise = torch::randn(out.residual.sizes(), generator) * out.open;
  out.self_conditioned = chance(random, kSelfConditioned);
  const Tensor joints = residual_joints(out.frames, out.residual),
               points = to_world(out.frames, guarded_points(out.frames, out.residual, joints));
  out.room = torch::minimum(probe(out.scenes, points).distance, guarded_radii());
  out.passes = passing_distance(out.scenes, to_world(out.frames, joints).select(2, 0));
  return out;
}

}  // namespace

ResidualBatch ResidualBatch::to(torch::Device device) const {
  ResidualBatch out = *this;
  out.frames = frames.to(device);
  for (Tensor* t : {&out.residual, &out.open, &out.fixed, &out.bones, &out.weights, &out.room, &out.passes, &out.feet,
                    &out.kept, &out.steps, &out.noise})
    *t = t->to(device);
  return out;
}

Tensor residual_table(const PoseWindows& data, const Config& config, uint64_t seed) {
  std::mt19937_64 random(seed);
  ResidualStatistics statistics;
  Config plain = config;
  plain.training.blocked = 0;
  plain.training.noisy = 0;
  for (int64_t i = 0; i < std::min(kScaleWindows, 20 * data.size()); ++i) {
    const Example e = draw_window(data, plain, random);
    statistics.add(residual_of(e.window.poses, e.baseline), e.baseline);
  }
  return statistics.table();
}

ResidualBatch draw_batch(const PoseWindows& data, const Config& config, const Tensor& table, size_t count,
                         uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Example> examples;
  examples.reserve(count);
  for (size_t i = 0; i < count; ++i) examples.push_back(draw_window(data, config, random));
  return make_batch(examples, config, table, random);
}

Tensor passing_distance(const std::vector<SceneDistances>& scenes, const Tensor& root) {
  const Tensor clear = probe(scenes, root_column(root)).distance.clamp_max(kPassesBy);
  // The least of a stretch is the largest of what is negative.
  return -torch::max_pool1d(-clear.transpose(1, 2), 2 * kSoonerOrLater + 1, 1, kSoonerOrLater).transpose(1, 2);
}

ResidualBatch twice(const ResidualBatch& batch, uint64_t seed) {
  ResidualBatch out = batch;
  const auto doubled = [](Tensor& values) { values = torch::cat({values, values}); };
  for (Tensor* values :
       {&out.frames.root, &out.frames.bones, &out.frames.ends, &out.frames.rotation, &out.frames.scale, &out.residual,
        &out.open, &out.fixed, &out.bones, &out.weights, &out.room, &out.passes, &out.feet, &out.kept, &out.steps})
    doubled(*values);
  DetourFrames& detours = out.frames.detours;
  if (detours.pace.defined())
    for (Tensor* values :
         {&detours.from, &detours.to, &detours.pace, &detours.direction, &detours.yaw, &detours.heading})
      doubled(*values);
  out.scenes.insert(out.scenes.end(), batch.scenes.begin(), batch.scenes.end());
  auto generator = at::detail::createCPUGenerator(seed);
  out.noise = torch::randn(out.residual.sizes(), generator) * out.open;
  return out;
}

}  // namespace inhabit::inbetween
