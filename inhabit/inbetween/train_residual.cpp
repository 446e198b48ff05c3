#include "inhabit/inbetween/train_residual.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "inhabit/error.h"
#include "inhabit/inbetween/drawn_keys.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/pose_windows.h"
#include "inhabit/inbetween/residual.h"
#include "inhabit/inbetween/residual_input.h"
#include "inhabit/inbetween/schedule.h"
#include "inhabit/math/random.h"
#include "inhabit/nn/bfloat16.h"
#include "inhabit/nn/parameters.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

constexpr double kFarKeys = 0.5;          // fraction of windows whose keys are 30 to 120 frames apart
constexpr double kSelfConditioned = 0.5;  // fraction of batches that see an earlier prediction
constexpr double kNoisiest = 0.2;         // fraction of windows at one of the noisiest tenth of the steps
constexpr int kDraws = 6;                 // windows looked at to find one whose baseline is blocked
constexpr float kInside = 0.03F;          // metres that a blocked baseline is inside obstacles
constexpr int64_t kScaleWindows = 2000, kValidationBatches = 6;
constexpr double kPlaceUnit = 0.1, kMoveUnit = 0.02, kInsideUnit = 0.05;  // metres; the second a frame
constexpr double kStanding = 0.008;                                       // metres a frame
constexpr double kTargetWeight = 10;                                      // of joints that partial keys constrain

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

Example draw_window(const PoseWindows& data, const Config& c, std::mt19937_64& random) {
  const bool recorded = data.generated().empty() || (!data.recorded().empty() && chance(random, c.training.recorded));
  const std::vector<int64_t>& windows = recorded ? data.recorded() : data.generated();
  const int draws = chance(random, c.training.blocked) ? kDraws : 1;
  std::optional<Example> first;
  for (int i = 0; i < draws; ++i) {
    const int64_t index = windows[static_cast<size_t>(uniform_int(random, 0, static_cast<int>(windows.size()) - 1))];
    PoseWindow window = data.window(index, chance(random, 0.5));
    const DrawnKeys keys = draw_keys(c.frames, c.partial_keys, draws > 1 ? 1 : kFarKeys, random);
    Baseline baseline = baseline_of(window.poses, keys.groups);
    if (i + 1 == draws || i == 0) first = Example{window, baseline};
    if (draws == 1 || blocked(window, baseline)) return {std::move(window), std::move(baseline)};
  }
  return std::move(*first);
}

struct ResidualBatch {
  ResidualFrames frames;
  Tensor residual;  // (B, 135, T) divided by its scale, 0 where that is 0
  Tensor open;      // (B, 135, T) 1 where the scale is not 0
  Tensor fixed;     // (B, 244, T) static_features
  Tensor bones;     // (B, 21)
  Tensor weights;   // (B, T, 22) of joints
  Tensor room;      // (B, T, 30) metres that the true body points keep from obstacles, their radius at most
  Tensor kept;      // (B) 1, or 0 where the scene is hidden
  Tensor steps;     // (B)
  Tensor noise;     // (B, 135, T)
  std::vector<SceneDistances> scenes;
  bool self_conditioned = false;
};

ResidualBatch make_batch(const std::vector<Example>& examples, const Config& c, const Tensor& table,
                         std::mt19937_64& random) {
  const torch::NoGradGuard no_gradients;
  ResidualBatch out;
  std::vector<const Baseline*> baselines;
  std::vector<Tensor> residuals, fixed, bones, weights;
  std::vector<float> kept;
  std::vector<int64_t> steps;
  for (const Example& e : examples) {
    baselines.push_back(&e.baseline);
    residuals.push_back(residual_of(e.window.poses, e.baseline));
    kept.push_back(chance(random, c.training.scene_dropout) ? 0.F : 1.F);
    const Tensor fan = kept.back() > 0 ? scene_fan(e.window.scene, e.baseline) : torch::zeros({c.frames, kFanFeatures});
    fixed.push_back(static_features(e.baseline, fan, c.rate));
    bones.push_back(bone_lengths(e.window.poses));
    weights.push_back(1 + (kTargetWeight - 1) * e.baseline.targets.select(2, 3));
    const int last = c.diffusion_steps - 1;
    steps.push_back(chance(random, kNoisiest) ? uniform_int(random, last - last / 10, last)
                                              : uniform_int(random, 0, last));
    out.scenes.push_back(e.window.scene);
  }
  out.frames = residual_frames(baselines, table);
  out.open = (out.frames.scale > 0).to(torch::kFloat32);
  out.residual = torch::stack(residuals) / out.frames.scale.clamp_min(1e-6) * out.open;
  out.fixed = torch::stack(fixed);
  out.bones = torch::stack(bones);
  out.weights = torch::stack(weights);
  out.kept = torch::tensor(kept);
  out.steps = torch::tensor(steps);
  auto generator = at::detail::createCPUGenerator(random());
  out.noise = torch::randn(out.residual.sizes(), generator) * out.open;
  out.self_conditioned = chance(random, kSelfConditioned);
  const Tensor points = body_points(to_world(out.frames, residual_joints(out.frames, out.residual)));
  std::vector<Tensor> room;
  for (size_t b = 0; b < examples.size(); ++b)
    room.push_back(probe(out.scenes[b], points[static_cast<int64_t>(b)]).distance);
  out.room = torch::minimum(torch::stack(room), body_point_radii());
  return out;
}

/// Distances of points (B, T, 30, 3) to each window's scene.
ProbedPoints probe_all(const std::vector<SceneDistances>& scenes, const Tensor& points) {
  std::vector<Tensor> distances, gradients;
  for (size_t b = 0; b < scenes.size(); ++b) {
    ProbedPoints one = probe(scenes[b], points[static_cast<int64_t>(b)]);
    distances.push_back(std::move(one.distance));
    gradients.push_back(std::move(one.gradient));
  }
  return {torch::stack(distances), torch::stack(gradients)};
}

/// One evaluation of the denoiser. @param before (B, 135, T) what it predicted before
Tensor denoise(const Networks& networks, const ResidualBatch& b, const Tensor& x, const Tensor& before, bool bfloat16) {
  Denoiser network = networks.network;
  Tensor seen;
  {
    const torch::NoGradGuard no_gradients;
    const Tensor points = body_points(to_world(b.frames, residual_joints(b.frames, before)));
    seen = point_features(probe_all(b.scenes, points), b.frames.turn) * b.kept.view({-1, 1, 1});
  }
  const Bfloat16Products products(bfloat16);
  const Tensor input = torch::cat({x, before, b.fixed, seen.transpose(1, 2)}, 1);
  return network->residual(input, b.steps, network->embed_shape(b.bones)).to(torch::kFloat32) * b.open;
}

/// sqrt(1 + (distance / unit)^2) - 1 from the square of a distance: quadratic below the unit, linear beyond, so that a
/// few windows in which anything could happen do not outweigh the others.
Tensor robust(const Tensor& square, double unit) { return (1 + square / (unit * unit)).sqrt() - 1; }

Tensor mean_over(const Tensor& values, const Tensor& mask) { return (values * mask).sum() / mask.sum().clamp_min(1); }

Losses residual_losses(const Networks& networks, const DiffusionSchedule& schedule, const ResidualBatch& b,
                       bool bfloat16) {
  const Config::Training& weigh = networks.config.training;
  const Tensor x = diffuse(schedule, b.residual, b.steps, b.noise);
  Tensor before = torch::zeros_like(x);
  if (b.self_conditioned) {
    const torch::NoGradGuard no_gradients;
    before = denoise(networks, b, x, before, bfloat16);
  }
  const Tensor predicted = denoise(networks, b, x, before, bfloat16);
  const Tensor simple = mean_over((predicted - b.residual).square(), b.open);
  const Tensor here = to_world(b.frames, residual_joints(b.frames, predicted));
  const Tensor there = to_world(b.frames, residual_joints(b.frames, b.residual)).detach();
  const Tensor off = here - there;                       // (B, T, 22, 3)
  const Tensor open = b.open.select(1, 3).unsqueeze(2);  // (B, T, 1) between keys
  const Tensor square = off.square().sum(3);             // (B, T, 22)
  const Tensor joints = mean_over(robust(square, kPlaceUnit) * b.weights, open.expand_as(square));
  const Tensor moving = torch::maximum(open.slice(1, 1), open.slice(1, 0, -1));
  const Tensor drift = off.diff(1, 1).square().sum(3);
  const Tensor velocity = mean_over(robust(drift, kMoveUnit), moving.expand_as(drift));
  const auto feet_of = [](const Tensor& j) { return j.index_select(2, torch::tensor({7, 8, 10, 11})).diff(1, 1); };
  const Tensor standing = (feet_of(there).norm(2, 3) < kStanding).to(torch::kFloat32) * moving;
  const Tensor feet = mean_over(feet_of(here).square().sum(3), standing) / (kMoveUnit * kMoveUnit);
  const Tensor points = body_points(here);
  const ProbedPoints probed = probe_all(b.scenes, points);
  // The distance as it changes with the points: its value and its gradient are the field's.
  const Tensor distance = probed.distance + (probed.gradient * (points - points.detach())).sum(3);
  const Tensor inside = ((b.room - distance).clamp_min(0) / kInsideUnit).square().sum(2).mean(1);  // (B)
  const Tensor penetration = mean_over(inside, b.kept);
  return {{"total", simple + weigh.joints_weight * joints + weigh.velocity_weight * velocity +
                        weigh.feet_weight * feet + weigh.penetration_weight * penetration},
          {"simple", simple},
          {"joints", joints},
          {"velocity", velocity},
          {"feet", feet},
          {"penetration", penetration},
          {"mm", mean_over(square.detach().sqrt(), open.expand_as(square)) * 1000}};
}

Tensor table_of(const PoseWindows& data, const Config& config, uint64_t seed) {
  std::mt19937_64 random(seed);
  ResidualStatistics statistics;
  Config plain = config;
  plain.training.blocked = 0;
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

}  // namespace

bool train_residual(const TrainRun& run, const Config& config) {
  const PoseWindows data(run.data, "train", config, config.training.stride),
      validation(run.data, "val", config, config.frames);
  if (data.size() == 0 || validation.size() == 0)
    throw Error(run.data.front(), "has no window of " + std::to_string(config.frames) +
                                      " frames in a scene in its split " + (data.size() == 0 ? "train" : "val"));
  Networks networks;
  networks.config = config;
  std::optional<Networks> start;
  if (!run.from.empty()) start = load_networks(run.from);
  if (start && !start->config.residual) throw Error(run.from, "is not of residual motion");
  networks.residual_table = start ? start->residual_table : table_of(data, config, run.seed);
  const SafeTensors header = model_header(networks);
  const DiffusionSchedule schedule = cosine_schedule(config.diffusion_steps);
  const auto make_task = [&] {
    networks.network = Denoiser(config);
    if (start) nn::load_parameters(*networks.network, "net.", read_safetensors(run.from), run.from);
    TrainTask task;
    task.settings = to_json(config) + (run.from.empty() ? "" : " from " + run.from);
    task.average = config.training.average;
    task.weight_decay = config.training.weight_decay;
    task.module = networks.network.ptr();
    task.networks = {{"net.", networks.network.ptr()}};
    task.samples = data.size();
    task.prepare = batches(
        [&](const TrainStep& step) {
          return draw_batch(data, config, networks.residual_table, step.indices.size(), step.seed);
        },
        [&](const ResidualBatch& b, const TrainStep&) {
          return residual_losses(networks, schedule, b, config.training.bfloat16);
        });
    task.validate = [&] {
      double sum = 0;
      for (int64_t i = 0; i < kValidationBatches; ++i) {
        const ResidualBatch batch =
            draw_batch(validation, config, networks.residual_table, 32, item_seed(run.seed, static_cast<uint64_t>(i)));
        sum += residual_losses(networks, schedule, batch, false).front().second.item<double>();
      }
      return sum / kValidationBatches;
    };
    return task;
  };
  return run_stages({{"denoiser", config.training.steps, config.training.batch, config.training.learning_rate,
                      config.training.schedule, 20, make_task}},
                    header, run);
}

}  // namespace inhabit::inbetween
