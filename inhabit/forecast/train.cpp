#include "inhabit/forecast/train.h"

#include <filesystem>
#include <map>
#include <optional>
#include <unordered_map>

#include "inhabit/error.h"
#include "inhabit/forecast/fast_contact_network.h"
#include "inhabit/forecast/features.h"
#include "inhabit/forecast/losses.h"
#include "inhabit/forecast/model_file.h"
#include "inhabit/forecast/sample.h"
#include "inhabit/math/random.h"
#include "inhabit/metrics/forecast_error.h"
#include "inhabit/train/stages.h"

namespace inhabit {
namespace {

// Stage "adapt" keeps a prediction of each of its windows: fewer, so that some 15,000 of 200 minutes take 150 MB.
constexpr int64_t kTrainStride = 5, kAdaptStride = 15, kValidationStride = 30, kValidationWindows = 192;

/// What a preset says about a stage: paper 4.2 for "paper"; "compact" sized for two hours on two cores.
struct Stage {
  std::string name;
  int64_t steps, batch;
  double rate;
};

/// The stages that a choice runs, in order.
const std::vector<std::string>& stages_of(ForecastTraining::Stage choice) {
  using Choice = ForecastTraining::Stage;
  static const std::map<Choice, std::vector<std::string>> stages = {
      {Choice::contact, {"contact"}},
      {Choice::motion, {"motion", "no_contact"}},
      {Choice::adapt, {"adapt"}},
      {Choice::trajectory, {"trajectory"}},
      {Choice::both, {"contact", "motion", "no_contact", "adapt"}},
      {Choice::all, {"contact", "motion", "no_contact", "adapt", "trajectory"}}};
  return stages.at(choice);
}

Stage stage_of(const ForecastTraining& options, const std::string& name, int64_t windows) {
  const bool contact = name == "contact", adapt = name == "adapt";
  Stage stage{name, contact ? 6500 : adapt ? 13000 : 10000, contact ? 8 : 32, 1e-3};
  if (options.preset == "paper") {
    stage.batch = contact ? 4 : 32;
    stage.steps = (adapt ? 10 : 50) * std::max<int64_t>(1, windows / stage.batch);
    if (contact) stage.rate = 5e-4;
  }
  if (options.batch > 0) stage.batch = options.batch;
  const int64_t asked = contact ? options.contact_steps : adapt ? options.adapt_steps : options.motion_steps;
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

/// Contact points (T, J, 4) of window `window`, the `place`-th of its batch, in the sample's axes.
using ContactSource = std::function<torch::Tensor(int64_t place, int64_t window, const ForecastSample& sample)>;

ContactSource no_contacts(const ForecastConfig& config) {
  return [&config](int64_t, int64_t, const ForecastSample&) { return torch::zeros({config.future, config.joints, 4}); };
}

ContactSource true_contacts(const ForecastConfig& config) {
  return [&config](int64_t, int64_t, const ForecastSample& s) {
    return true_contact_points(s.points.unsqueeze(0), s.joints.slice(0, config.past).unsqueeze(0), config)[0];
  };
}

/// What the contact network predicts, in every `period`-th window of a batch the truth. A window's prediction is made
/// once and kept (10 kB): its scene points must be the same every time.
ContactSource predicted_contacts(const ForecastConfig& config, const ContactNetwork& network, int64_t period) {
  auto contact = std::make_shared<FastContactNetwork>(network);
  auto known = std::make_shared<std::unordered_map<int64_t, torch::Tensor>>();
  return [&config, contact, known, period, truth = true_contacts(config)](int64_t place, int64_t window,
                                                                          const ForecastSample& s) {
    if (period > 0 && place % period == 0) return truth(place, window, s);
    torch::Tensor& kept = (*known)[window];
    if (!kept.defined()) {
      const torch::Tensor points = s.points.unsqueeze(0), past = s.joints.slice(0, 0, config.past).unsqueeze(0);
      const torch::Tensor dct = contact->forward(points, contact_features(points, past, config), past);
      kept = contact_points(points, dct, config)[0].to(torch::kHalf);
    }
    return kept.to(torch::kFloat);
  };
}

/// Past, future, contact points. Scene points are drawn from `point_seed`, the augmentation from `seed`.
Batch motion_batch(const ForecastData& data, const ForecastConfig& config, const std::vector<int64_t>& windows,
                   const ContactSource& contacts, uint64_t point_seed, std::optional<uint64_t> seed) {
  torch::NoGradGuard no_grad;
  std::vector<torch::Tensor> joints, touching;
  for (size_t i = 0; i < windows.size(); ++i) {
    ForecastSample s = data.sample(windows[i], point_seed, false);
    torch::Tensor contact = contacts(static_cast<int64_t>(i), windows[i], s);
    if (seed) {
      std::mt19937_64 random(item_seed(*seed, static_cast<uint64_t>(windows[i])));
      const Augmentation moved = draw_augmentation(config, random);
      s.joints = moved(s.joints);
      const torch::Tensor flag = contact.narrow(2, 3, 1);
      contact = torch::cat({moved(contact.narrow(2, 0, 3)) * flag, flag}, 2);
    }
    joints.push_back(s.joints);
    touching.push_back(contact);
  }
  const torch::Tensor all = torch::stack(joints);
  return {all.slice(1, 0, config.past).contiguous(), all.slice(1, config.past).contiguous(), torch::stack(touching)};
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

/// Stage "motion", "no_contact" or "adapt".
TrainTask motion_task(const std::string& stage, ForecastNetworks& model, const ForecastData& data,
                      const ForecastData& validation, torch::Device device) {
  const ForecastConfig& config = model.config;
  MotionNetwork network = stage == "no_contact" ? model.no_contact : model.motion;
  const bool adapt = stage == "adapt";
  // Preparing runs beside validation, so that each has its own contact network.
  const auto contacts = [&](int64_t period) {
    if (adapt) return predicted_contacts(config, model.contact, period);
    return stage == "motion" ? true_contacts(config) : no_contacts(config);
  };
  TrainTask task;
  task.name = stage;
  task.module = network.ptr();
  task.samples = data.size();
  task.prepare = [&, adapt, source = contacts(2)](const std::vector<int64_t>& windows, uint64_t seed) {
    return motion_batch(data, config, windows, source, adapt ? 0 : seed, seed);
  };
  task.losses = [&config, network, device](const Batch& b) mutable {
    const MotionLosses l =
        motion_losses(network->forward(b[0].to(device), b[2].to(device)), b[1].to(device), b[2].to(device), config);
    return Losses{{"total", l.total}, {"root", l.root}, {"local", l.local}, {"contact", l.contact}};
  };
  task.validate = [&, network, source = contacts(0), device]() mutable {
    double sum = 0;
    const auto windows = validation_windows(validation);
    for (size_t first = 0; first < windows.size(); first += 32) {
      const std::vector<int64_t> some(windows.begin() + static_cast<int64_t>(first),
                                      windows.begin() + static_cast<int64_t>(std::min(first + 32, windows.size())));
      const Batch b = motion_batch(validation, config, some, source, 0, {});
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

/// LTD: mean joint error in the world.
TrainTask trajectory_task(ForecastNetworks& model, const ForecastData& data, const ForecastData& validation,
                          torch::Device device) {
  const ForecastConfig& config = model.config;
  auto forecast = [network = model.trajectory, &config, device](const torch::Tensor& past) mutable {
    return network->forward(past.to(device).flatten(2)).unflatten(2, {config.joints, 3});
  };
  TrainTask task;
  task.name = "trajectory";
  task.module = model.trajectory.ptr();
  task.samples = data.size();
  task.prepare = [&, source = no_contacts(config)](const std::vector<int64_t>& windows, uint64_t seed) {
    return motion_batch(data, config, windows, source, seed, seed);
  };
  task.losses = [forecast, device](const Batch& b) mutable {
    const torch::Tensor error = (forecast(b[0]) - b[1].to(device)).square().sum(3) + 1e-10;
    return Losses{{"joints", error.sqrt().mean()}};
  };
  task.validate = [&, forecast, source = no_contacts(config)]() mutable {
    double sum = 0;
    const auto windows = validation_windows(validation);
    for (const int64_t w : windows) {
      const Batch b = motion_batch(validation, config, {w}, source, 0, {});
      sum += (forecast(b[0]).cpu() - b[1]).norm(2, {3}).mean().item<double>();
    }
    return sum / static_cast<double>(windows.size());
  };
  return task;
}

}  // namespace

bool train_forecast(const ForecastTraining& options) {
  const ForecastConfig config = forecast_preset(options.preset);
  const ForecastData data(options.data, "train", config, kTrainStride),
      adapt_data(options.data, "train", config, kAdaptStride),
      validation(options.data, "val", config, kValidationStride);
  if (data.size() == 0)
    throw Error(options.data.front(),
                "has no training window of " + std::to_string(config.past + config.future) + " frames");
  if (validation.size() == 0) throw Error(options.data.front(), "has no validation window");

  const std::vector<std::string>& stages = stages_of(options.stage);
  const size_t first = first_stage(options.out, stages, options.resume);

  // What earlier stages (of this run or another) left in the model file is kept, but by a run of them all, which begins
  // it anew; a network without weights is not written.
  torch::manual_seed(options.seed);
  ForecastNetworks model{config, ContactNetwork(config), MotionNetwork(config),
                         MotionNetwork(config, /*with_contact=*/false), make_trajectory_network(config)};
  const bool keep = std::filesystem::exists(options.out) &&
                    (options.resume || stages.size() < stages_of(ForecastTraining::Stage::both).size());
  for (size_t s = first; s < stages.size(); ++s) {
    // The file holds the best of earlier stages and, each time this one validates better, its weights of that moment.
    const ForecastNetworks before = std::filesystem::exists(options.out) && (keep || s > first)
                                        ? load_forecast_networks(options.out)
                                        : ForecastNetworks{};
    if (keep && !(before.config == config)) throw Error(options.out, "holds networks of another configuration");
    if (stages[s] == "adapt") {
      if (before.contact.is_empty() || before.motion.is_empty())
        throw Error(options.out, "lacks the contact or the motion network that stage adapt goes on from");
      model.contact = before.contact;
      model.motion = load_forecast_networks(options.out).motion;  // `before` keeps its own until this one is better
    }
    const ForecastData& windows = stages[s] == "adapt" ? adapt_data : data;
    TrainTask task = stages[s] == "contact"      ? contact_task(model, windows, validation, options.device)
                     : stages[s] == "trajectory" ? trajectory_task(model, windows, validation, options.device)
                                                 : motion_task(stages[s], model, windows, validation, options.device);
    task.module->to(options.device);
    task.on_best = [&, name = stages[s]] {
      ForecastNetworks best = before;
      best.config = config;
      if (name == "contact") best.contact = model.contact;
      if (name == "motion" || name == "adapt") best.motion = model.motion;
      if (name == "no_contact") best.no_contact = model.no_contact;
      if (name == "trajectory") best.trajectory = model.trajectory;
      save_forecast_networks(options.out, best);
    };
    const Stage stage = stage_of(options, stages[s], windows.size());
    TrainOptions loop = stage_options(options.out, s, first, options.resume);
    loop.steps = stage.steps;
    loop.batch = stage.batch;
    loop.learning_rate = stage.rate;
    loop.validate_every = std::clamp<int64_t>(stage.steps / 12, 1, 500);
    loop.seed = options.seed;
    if (train(task, loop).interrupted) return false;
  }
  return true;
}

}  // namespace inhabit
