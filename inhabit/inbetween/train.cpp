#include "inhabit/inbetween/train.h"

#include <cmath>
#include <optional>

#include "inhabit/error.h"
#include "inhabit/inbetween/conditioning.h"
#include "inhabit/inbetween/denoiser_task.h"
#include "inhabit/inbetween/drawn_keys.h"
#include "inhabit/inbetween/features.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/losses.h"
#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/motion_autoencoder.h"
#include "inhabit/inbetween/obstacle_detours.h"
#include "inhabit/inbetween/sample.h"
#include "inhabit/inbetween/sampler.h"
#include "inhabit/inbetween/schedule.h"
#include "inhabit/inbetween/train_residual.h"
#include "inhabit/math/random.h"
#include "inhabit/math/rotation.h"
#include "inhabit/nn/bfloat16.h"
#include "inhabit/train/stages.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

constexpr int64_t kValidationWindows = 192;
constexpr double kLeastDeviation = 0.01, kLeastRotationDeviation = 0.1;  // metres, and of a rotation's 6D

/// Windows as the denoiser is trained on them.
struct WindowBatch {
  Conditioning conditioning;
  Tensor features;    // (B, 201, T) standardised
  Tensor bones;       // (B, 22, 3)
  Tensor scene_kept;  // (B) 1, or 0 where the global scene is hidden
  Tensor steps;       // (B) diffusion steps
  Tensor noise;       // (B, 201, T)

  void to(torch::Device device) {
    Conditioning& c = conditioning;
    for (Tensor* t : {&c.constraints.values, &c.constraints.mask, &c.constraints.always, &c.groups, &c.occupancy,
                      &c.offsets, &c.shape, &c.detours, &features, &bones, &scene_kept, &steps, &noise})
      *t = t->to(device);
  }
};

WindowBatch window_batch(const Data& data, const Config& c, const FeatureScale& scale,
                         const std::vector<int64_t>& indices, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Tensor> features, occupancy, offsets, shape, bones, keys, groups, ends, detours;
  std::vector<int64_t> steps;
  std::vector<float> kept;
  for (const int64_t index : indices) {
    Sample s = data.sample(index);
    if (c.training.rest_rotation > 0) {
      auto draws = at::detail::createCPUGenerator(random());
      const double deviation = uniform(random, 0, c.training.rest_rotation) * M_PI / 180;
      s.features = with_rest_frames_rotated(
          s.features, axis_angle_to_matrix(torch::randn({kStandardJoints, 3}, draws) * deviation), s.bones);
    }
    features.push_back(scale.to_network(s.features).t());
    occupancy.push_back(s.occupancy);
    offsets.push_back(s.offsets.permute({1, 2, 0}));
    shape.push_back(s.body_shape);
    bones.push_back(s.bones);
    const DrawnKeys drawn = draw_keys(c.frames, c.partial_keys, 0, random);
    groups.push_back(drawn.groups);
    ends.push_back(drawn.ends);
    Tensor key_values = s.features;
    if (c.t_star > 0)
      key_values = torch::where(drawn.ends.unsqueeze(1) > 0, key_values,
                                noisy_features(key_values, s.bones, uniform(random, 0, 1), random));
    keys.push_back(scale.to_network(key_values).t());
    detours.push_back(c.around_obstacles && c.global_scene
                          ? detours_around(s.floor, key_values.slice(1, 0, 3), drawn.groups)
                          : torch::zeros({c.frames, 2}));
    steps.push_back(uniform_int(random, 0, c.diffusion_steps - 1));
    kept.push_back(chance(random, c.training.scene_dropout) ? 0.F : 1.F);
  }
  auto generator = at::detail::createCPUGenerator(random());
  WindowBatch out;
  out.features = torch::stack(features);
  out.bones = torch::stack(bones);
  out.scene_kept = torch::tensor(kept);
  out.steps = torch::tensor(steps);
  out.noise = torch::randn({static_cast<int64_t>(indices.size()), kFeatureCount, c.frames}, generator);
  Conditioning& on = out.conditioning;
  on.groups = torch::stack(groups);
  on.constraints.values = torch::stack(keys);
  on.constraints.mask = feature_mask(on.groups).transpose(1, 2);
  on.constraints.always = on.constraints.mask * torch::stack(ends).unsqueeze(1);
  on.constraints.t_star = c.t_star;
  on.occupancy = torch::stack(occupancy);
  on.offsets = torch::stack(offsets);
  on.shape = torch::stack(shape);
  on.detours = torch::stack(detours);
  return out;
}

/// What the network makes of a batch, in float32.
Tensor predict(const Networks& networks, const WindowBatch& b, const Tensor& x, bool bfloat16) {
  Denoiser network = networks.network;
  const Bfloat16Products products(bfloat16);
  const DenoiserInput in = denoiser_input(networks, b.conditioning);
  Tensor embedding = in.shape;
  if (in.scene.defined()) embedding = embedding + in.scene * b.scene_kept.unsqueeze(1);
  return network->forward(x, in.mask, in.local, b.steps, embedding).to(torch::kFloat32) +
         in.baseline.to(torch::kFloat32);
}

Losses window_losses(const Networks& networks, const DiffusionSchedule& schedule, const WindowBatch& b, bool bfloat16) {
  const Tensor noisy = diffuse(schedule, b.features, b.steps, b.noise);
  const Tensor x = networks.config.keys_seen ? impute(noisy, b.conditioning.constraints, b.steps) : noisy;
  return loss_terms(predict(networks, b, x, bfloat16), b.features, b.bones, networks.scale, networks.config);
}

/// Mean and deviation of every feature over `data`; at least kLeastDeviation, as the first root stands at the origin in
/// every window, and kLeastRotationDeviation for rotations, as joints that hardly rotate here may elsewhere.
FeatureScale scale_of(const Data& data) {
  FeatureStatistics statistics;
  const int64_t stride = std::max<int64_t>(1, data.size() / 1000);
  for (int64_t i = 0; i < data.size(); i += stride) statistics.add(data.features(i));
  FeatureScale scale = statistics.scale();
  scale.deviation.clamp_min_(kLeastDeviation)
      .slice(0, kOrientFeature, kJointFeature)
      .clamp_min_(kLeastRotationDeviation);
  return scale;
}

/// Joints (N, T, 22, 3) of all windows of a split.
Tensor window_joints(const Data& data) {
  std::vector<Tensor> out;
  for (int64_t i = 0; i < data.size(); ++i)
    out.push_back(data.features(i).slice(1, kJointFeature).reshape({-1, kStandardJoints, 3}));
  return torch::stack(out);
}

/// Copies the weights of a network that sees at least as much.
void adopt_weights(DenoiserImpl& network, const DenoiserImpl& start, const std::string& file) {
  const torch::NoGradGuard no_gradients;
  const auto parameters = start.named_parameters();
  const int64_t at = kFeatureCount + network.config.mask_channels();  // where the offsets' channels come in
  const bool no_offsets = start.config.local_scene && !network.config.local_scene;
  for (auto& p : network.named_parameters()) {
    const Tensor* found = parameters.find(p.key());
    Tensor value = found != nullptr ? *found : Tensor();
    if (found != nullptr && no_offsets && value.dim() == 3 && value.size(1) == p.value().size(1) + kLocalChannels)
      value = torch::cat({value.slice(1, 0, at), value.slice(1, at + kLocalChannels)}, 1);
    if (found == nullptr || value.sizes() != p.value().sizes())
      throw Error(file, "is of another configuration than this training");
    p.value().copy_(value);
  }
}

void require_windows(const TrainRun& run, const Config& config, const Data& train, const Data& validation) {
  if (train.size() == 0 || validation.size() == 0)
    throw Error(run.data.front(), "has no window of " + std::to_string(config.frames) +
                                      " frames in a scene in its split " + (train.size() == 0 ? "train" : "val"));
}

TrainStage stage_of(const Config& config, const std::string& name, std::function<TrainTask()> task) {
  return {name, config.training.steps, config.training.batch, config.training.learning_rate, config.training.schedule,
          20,   std::move(task)};
}

}  // namespace

bool train_motion_features(const TrainRun& run, const Config& config) {
  const Data data(run.data, "train", config, config.training.stride),
      validation(run.data, "val", config, config.frames);
  require_windows(run, config, data, validation);
  MotionAutoencoder network;
  const auto task = [&] {
    network = MotionAutoencoder();
    return motion_autoencoder_task(network, window_joints(data), window_joints(validation));
  };
  return run_stages({stage_of(config, "motion_features", task)}, motion_autoencoder_header(), run);
}

bool train(const TrainRun& run, const Config& config) {
  validate(config, run.out);
  if (run.data.empty() && !(config.residual && run.stages == std::vector<std::string>{"path"}))
    throw Error("--data", "is missing: all stages but 'path' are trained on motion");
  if (config.residual) return train_residual(run, config);
  chosen_stages(run.stages, {"denoiser"}, {});
  const Data data(run.data, "train", config, config.training.stride),
      validation(run.data, "val", config, config.frames);
  require_windows(run, config, data, validation);
  Networks networks;
  networks.config = config;
  std::optional<Networks> start;
  if (!run.from.empty()) start = load_networks(run.from);
  networks.scale = start ? start->scale : scale_of(data);
  const SafeTensors header = model_header(networks);
  const FeatureScale scale = networks.scale;  // what batches are made with, on the CPU
  networks.scale = scale.to(run.device);
  const DiffusionSchedule schedule = cosine_schedule(config.diffusion_steps);

  const auto make_task = [&] {
    networks.network = Denoiser(config);
    if (start) adopt_weights(*networks.network, *start->network, run.from);
    TrainTask task = denoiser_task(networks, run, data.size());
    const auto losses = [&](WindowBatch batch, bool bfloat16) {
      batch.to(run.device);
      return window_losses(networks, schedule, batch, bfloat16);
    };
    task.prepare =
        batches([&](const TrainStep& step) { return window_batch(data, config, scale, step.indices, step.seed); },
                [&, losses](const WindowBatch& b, const TrainStep&) { return losses(b, config.training.bfloat16); });
    // The geometric mean over windows: in the plain one, single windows whose 6D rotations flip outweigh all others.
    task.validate = [&, losses] {
      double sum = 0;
      const std::vector<int64_t> windows = validation.windows().spread(kValidationWindows);
      for (size_t i = 0; i < windows.size(); ++i) {
        const WindowBatch window = window_batch(validation, config, scale, {windows[i]}, item_seed(run.seed, i));
        sum += std::log(losses(window, false).front().second.item<double>());
      }
      return std::exp(sum / static_cast<double>(windows.size()));
    };
    return task;
  };
  return run_stages({stage_of(config, "denoiser", make_task)}, header, run, completed_by(config_from_json));
}

}  // namespace inhabit::inbetween
