#include "inhabit/forecast/train.h"

#include <filesystem>

#include "inhabit/error.h"
#include "inhabit/forecast/features.h"
#include "inhabit/forecast/losses.h"
#include "inhabit/forecast/model_file.h"
#include "inhabit/forecast/sample.h"
#include "inhabit/io/safetensors.h"
#include "inhabit/metrics/forecast_error.h"

namespace inhabit {
namespace {

constexpr int64_t kTrainStride = 5, kValidationStride = 30, kValidationWindows = 192;

/// What a preset says about a stage: paper 4.2 for "paper"; "compact" sized for two hours on two cores.
struct Stage {
  std::string name;
  int64_t steps, batch;
  double rate;
};

Stage stage_of(const ForecastTraining& options, const std::string& name, int64_t windows) {
  const bool contact = name == "contact";
  Stage stage{name, contact ? 6000 : 12000, contact ? 8 : 32, contact ? 1e-3 : 1e-3};
  if (options.preset == "paper") {
    stage.batch = contact ? 4 : 32;
    stage.steps = 50 * std::max<int64_t>(1, windows / stage.batch);
    stage.rate = contact ? 5e-4 : 1e-3;
  }
  if (options.batch > 0) stage.batch = options.batch;
  const int64_t asked = contact ? options.contact_steps : options.motion_steps;
  if (asked > 0) stage.steps = asked;
  return stage;
}

/// Evenly spread windows of the validation split.
std::vector<int64_t> validation_windows(const ForecastData& data) {
  std::vector<int64_t> out;
  const int64_t n = std::min(data.size(), kValidationWindows);
  for (int64_t i = 0; i < n; ++i) out.push_back(i * data.size() / n);
  return out;
}

/// Joints (B, P+T, J, 3) and points (B, N, 3) of windows.
std::pair<torch::Tensor, torch::Tensor> read_windows(const ForecastData& data, const std::vector<int64_t>& windows,
                                                     uint64_t seed, bool augment) {
  std::vector<torch::Tensor> joints, points;
  for (const int64_t i : windows) {
    const ForecastSample s = data.sample(i, seed, augment);
    joints.push_back(s.joints);
    points.push_back(s.points);
  }
  return {torch::stack(joints), torch::stack(points)};
}

/// Points, padded contact DCT, past, true contact DCT.
Batch contact_batch(const ForecastData& data, const ForecastConfig& config, const std::vector<int64_t>& windows,
                    uint64_t seed, bool augment) {
  torch::NoGradGuard no_grad;
  const auto [joints, points] = read_windows(data, windows, seed, augment);
  const torch::Tensor past = joints.slice(1, 0, config.past).contiguous();
  return {points, contact_features(points, past, config), past, contact_targets(points, joints, config)};
}

Batch motion_batch(const ForecastData& data, const ForecastConfig& config, const std::vector<int64_t>& windows,
                   uint64_t seed, bool augment, bool with_contact) {
  torch::NoGradGuard no_grad;
  const auto [joints, points] = read_windows(data, windows, seed, augment);
  const torch::Tensor past = joints.slice(1, 0, config.past).contiguous(),
                      future = joints.slice(1, config.past).contiguous();
  return {past, future,
          with_contact ? true_contact_points(points, future, config)
                       : torch::zeros({past.size(0), config.future, config.joints, 4})};
}

TrainTask contact_task(ForecastNetworks& model, const ForecastData& data, const ForecastData& validation,
                       torch::Device device) {
  const ForecastConfig& config = model.config;
  auto loss = [&model, device](const Batch& b) {
    return contact_map_loss(model.contact->forward(b[0].to(device), b[1].to(device), b[2].to(device)), b[3].to(device),
                            model.config);
  };
  TrainTask task;
  task.name = "contact";
  task.module = model.contact.ptr();
  task.samples = data.size();
  task.prepare = [&](const std::vector<int64_t>& windows, uint64_t seed) {
    return contact_batch(data, config, windows, seed, true);
  };
  task.losses = [loss](const Batch& b) { return Losses{{"map", loss(b)}}; };
  task.validate = [&, loss] {
    double sum = 0;
    const auto windows = validation_windows(validation);
    for (const int64_t w : windows) sum += loss(contact_batch(validation, config, {w}, 0, false)).item<double>();
    return sum / static_cast<double>(windows.size());
  };
  return task;
}

TrainTask motion_task(ForecastNetworks& model, bool with_contact, const ForecastData& data,
                      const ForecastData& validation, torch::Device device) {
  const ForecastConfig& config = model.config;
  MotionNetwork network = with_contact ? model.motion : model.no_contact;
  TrainTask task;
  task.name = with_contact ? "motion" : "no_contact";
  task.module = network.ptr();
  task.samples = data.size();
  task.prepare = [&, with_contact](const std::vector<int64_t>& windows, uint64_t seed) {
    return motion_batch(data, config, windows, seed, true, with_contact);
  };
  task.losses = [&config, network, device](const Batch& b) mutable {
    const MotionLosses l =
        motion_losses(network->forward(b[0].to(device), b[2].to(device)), b[1].to(device), b[2].to(device), config);
    return Losses{{"total", l.total}, {"root", l.root}, {"local", l.local}, {"contact", l.contact}};
  };
  task.validate = [&, network, with_contact, device]() mutable {
    double sum = 0;
    const auto windows = validation_windows(validation);
    for (size_t first = 0; first < windows.size(); first += 32) {
      const std::vector<int64_t> some(windows.begin() + static_cast<int64_t>(first),
                                      windows.begin() + static_cast<int64_t>(std::min(first + 32, windows.size())));
      const Batch b = motion_batch(validation, config, some, 0, false, with_contact);
      const torch::Tensor joints =
          forecast_joints(network->forward(b[0].to(device), b[2].to(device)), config.root).cpu();
      sum += (path_error(joints, b[1], config.root).mean(1) + pose_error(joints, b[1], config.root).mean(1))
                 .sum()
                 .item<double>();
    }
    return sum / static_cast<double>(windows.size());
  };
  return task;
}

}  // namespace

bool train_forecast(const ForecastTraining& options) {
  const ForecastConfig config = forecast_preset(options.preset);
  const ForecastData data(options.data, "train", config, kTrainStride),
      validation(options.data, "val", config, kValidationStride);
  if (data.size() == 0)
    throw Error(options.data.front(),
                "has no training window of " + std::to_string(config.past + config.future) + " frames");
  if (validation.size() == 0) throw Error(options.data.front(), "has no validation window");

  std::vector<std::string> stages;
  if (options.stage != ForecastTraining::Stage::motion) stages.push_back("contact");
  if (options.stage != ForecastTraining::Stage::contact) stages.insert(stages.end(), {"motion", "no_contact"});

  const std::string checkpoint = options.out + ".checkpoint.safetensors";
  size_t first_stage = 0;
  if (options.resume) {
    const auto state = read_safetensors_metadata(checkpoint);
    const auto run = state.find("run");
    const std::string name = run == state.end() ? "" : run->second.substr(0, run->second.find(' '));
    first_stage = static_cast<size_t>(std::find(stages.begin(), stages.end(), name) - stages.begin());
    if (first_stage == stages.size()) throw Error(checkpoint, "is not a checkpoint of the stages asked for");
  }

  // What earlier stages (of this run or another) left in the model file is kept; a network without weights is not
  // written.
  torch::manual_seed(options.seed);
  ForecastNetworks model{config, ContactNetwork(config), MotionNetwork(config),
                         MotionNetwork(config, /*with_contact=*/false)};
  const bool keep =
      std::filesystem::exists(options.out) && (options.resume || options.stage == ForecastTraining::Stage::motion);
  for (size_t s = first_stage; s < stages.size(); ++s) {
    TrainTask task = stages[s] == "contact"
                         ? contact_task(model, data, validation, options.device)
                         : motion_task(model, stages[s] == "motion", data, validation, options.device);
    task.module->to(options.device);
    // The file holds the best of earlier stages and, each time this one validates better, its weights of that moment.
    const ForecastNetworks before = std::filesystem::exists(options.out) && (keep || s > first_stage)
                                        ? load_forecast_networks(options.out)
                                        : ForecastNetworks{};
    task.on_best = [&, name = stages[s]] {
      ForecastNetworks best = before;
      best.config = config;
      if (name == "contact") best.contact = model.contact;
      if (name == "motion") best.motion = model.motion;
      if (name == "no_contact") best.no_contact = model.no_contact;
      save_forecast_networks(options.out, best);
    };
    const Stage stage = stage_of(options, stages[s], data.size());
    TrainOptions loop;
    loop.steps = stage.steps;
    loop.batch = stage.batch;
    loop.learning_rate = stage.rate;
    loop.validate_every = std::max<int64_t>(1, stage.steps / 12);
    loop.seed = options.seed;
    loop.resume = options.resume && s == first_stage;
    loop.checkpoint = checkpoint;
    loop.log = options.out + ".log.jsonl";
    loop.append_log = s > 0 || loop.resume;
    if (train(task, loop).interrupted) return false;
  }
  return true;
}

}  // namespace inhabit
