#include "inhabit/forecast/train.h"

#include <filesystem>
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
#include "inhabit/nn/parameters.h"
#include "inhabit/train/stages.h"

namespace inhabit::forecast {
namespace {

// Stage "adapt" keeps a prediction of each of its windows: fewer, so that some 15,000 of 200 minutes take 150 MB.
constexpr int64_t kAdaptStride = 15, kValidationStride = 30, kValidationWindows = 192;

/// Windows as the contact network is trained on them.
struct ContactBatch {
  torch::Tensor points;    // (B, N, 3)
  torch::Tensor features;  // (B, J L, N) DCT of the padded past's contact maps
  torch::Tensor past;      // (B, P, J, 3)
  torch::Tensor target;    // (B, J L, N) DCT of the true contact maps

  ContactBatch on(torch::Device d) const { return {points.to(d), features.to(d), past.to(d), target.to(d)}; }
};

ContactBatch contact_batch(const Data& data, const Config& config, const std::vector<int64_t>& windows, uint64_t seed,
                           bool augment) {
  torch::NoGradGuard no_grad;
  std::vector<torch::Tensor> all_joints, all_points;
  for (const int64_t i : windows) {
    const Sample s = data.sample(i, seed, augment);
    all_joints.push_back(s.joints);
    all_points.push_back(s.points);
  }
  const torch::Tensor joints = torch::stack(all_joints), points = torch::stack(all_points);
  const torch::Tensor past = joints.slice(1, 0, config.past).contiguous();
  return {points, contact_features(points, past, config), past, contact_targets(points, joints, config)};
}

/// Windows as motion networks are trained on them.
struct MotionBatch {
  torch::Tensor past;      // (B, P, J, 3)
  torch::Tensor future;    // (B, T, J, 3)
  torch::Tensor contacts;  // (B, T, J, 4) contact points

  MotionBatch on(torch::Device d) const { return {past.to(d), future.to(d), contacts.to(d)}; }
};

/// Contact points (T, J, 4) of window `window`, the `place`-th of its batch, in the sample's axes.
using ContactSource = std::function<torch::Tensor(int64_t place, int64_t window, const Sample& sample)>;

ContactSource no_contacts(const Config& config) {
  return [&config](int64_t, int64_t, const Sample&) { return torch::zeros({config.future, config.joints, 4}); };
}

ContactSource true_contacts(const Config& config) {
  return [&config](int64_t, int64_t, const Sample& s) {
    return true_contact_points(s.points.unsqueeze(0), s.joints.slice(0, config.past).unsqueeze(0), config)[0];
  };
}

/// What the contact network predicts, in every `period`-th window of a batch the truth. A window's prediction is made
/// once and kept (10 kB): its scene points must be the same every time.
ContactSource predicted_contacts(const Config& config, const ContactNetwork& network, int64_t period) {
  auto contact = std::make_shared<FastContactNetwork>(network);
  auto known = std::make_shared<std::unordered_map<int64_t, torch::Tensor>>();
  return
      [&config, contact, known, period, truth = true_contacts(config)](int64_t place, int64_t window, const Sample& s) {
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

/// Scene points are drawn from `point_seed`, the augmentation from `seed`.
MotionBatch motion_batch(const Data& data, const Config& config, const std::vector<int64_t>& windows,
                         const ContactSource& contacts, uint64_t point_seed, std::optional<uint64_t> seed) {
  torch::NoGradGuard no_grad;
  std::vector<torch::Tensor> joints, touching;
  for (size_t i = 0; i < windows.size(); ++i) {
    Sample s = data.sample(windows[i], point_seed, false);
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

/// The mean over evenly spread windows of the validation split of what `error` sums over some of them.
double validated(const Data& data, size_t together, const std::function<double(const std::vector<int64_t>&)>& error) {
  const std::vector<int64_t> windows = data.windows().spread(kValidationWindows);
  double sum = 0;
  for (size_t first = 0; first < windows.size(); first += together)
    sum += error({windows.begin() + static_cast<int64_t>(first),
                  windows.begin() + static_cast<int64_t>(std::min(first + together, windows.size()))});
  return sum / static_cast<double>(windows.size());
}

TrainTask contact_task(Networks& model, const Data& data, const Data& validation, torch::Device device) {
  const Config& config = model.config;
  const auto loss = [&model, device](const ContactBatch& on_cpu) {
    const ContactBatch b = on_cpu.on(device);
    return contact_map_loss(model.contact->forward(b.points, b.features, b.past), b.target, model.config);
  };
  TrainTask task;
  task.module = model.contact.ptr();
  task.networks = {{"contact_net.", model.contact.ptr()}};
  task.samples = data.size();
  task.prepare =
      batches([&](const TrainStep& step) { return contact_batch(data, config, step.indices, step.seed, true); },
              [loss](const ContactBatch& b, const TrainStep&) {
                return Losses{{"map", loss(b)}};
              });
  task.validate = [&, loss] {
    return validated(validation, 1, [&](const std::vector<int64_t>& some) {
      return loss(contact_batch(validation, config, some, 0, false)).item<double>();
    });
  };
  return task;
}

/// Stage "motion", "no_contact" or "adapt".
TrainTask motion_task(const std::string& stage, Networks& model, const Data& data, const Data& validation,
                      torch::Device device) {
  const Config& config = model.config;
  MotionNetwork network = stage == "no_contact" ? model.no_contact : model.motion;
  const bool adapt = stage == "adapt";
  // Preparing runs beside validation, so that each has its own contact network.
  const auto contacts = [&](int64_t period) {
    if (adapt) return predicted_contacts(config, model.contact, period);
    return stage == "motion" ? true_contacts(config) : no_contacts(config);
  };
  TrainTask task;
  task.module = network.ptr();
  task.networks = {{stage == "no_contact" ? "no_contact_net." : "motion_net.", network.ptr()}};
  task.samples = data.size();
  task.prepare = batches(
      [&, adapt, source = contacts(2)](const TrainStep& step) {
        return motion_batch(data, config, step.indices, source, adapt ? 0 : step.seed, step.seed);
      },
      [&config, network, device](const MotionBatch& on_cpu, const TrainStep&) mutable {
        const MotionBatch b = on_cpu.on(device);
        const MotionLosses l = motion_losses(network->forward(b.past, b.contacts), b.future, b.contacts, config);
        return Losses{{"total", l.total}, {"root", l.root}, {"local", l.local}, {"contact", l.contact}};
      });
  task.validate = [&, network, source = contacts(0), device]() mutable {
    return validated(validation, 32, [&](const std::vector<int64_t>& some) {
      const MotionBatch b = motion_batch(validation, config, some, source, 0, {});
      const torch::Tensor joints =
          forecast_joints(network->forward(b.past.to(device), b.contacts.to(device)), config.root).cpu();
      return (path_error(joints, b.future, config.root).mean(1) + pose_error(joints, b.future, config.root).mean(1))
          .sum()
          .item<double>();
    });
  };
  return task;
}

/// LTD: mean joint error in the world.
TrainTask ltd_task(Networks& model, const Data& data, const Data& validation, torch::Device device) {
  const Config& config = model.config;
  auto forecast = [network = model.ltd, &config, device](const torch::Tensor& past) mutable {
    return network->forward(past.to(device).flatten(2)).unflatten(2, {config.joints, 3});
  };
  TrainTask task;
  task.module = model.ltd.ptr();
  task.networks = {{"ltd_net.", model.ltd.ptr()}};
  task.samples = data.size();
  task.prepare = batches(
      [&, source = no_contacts(config)](const TrainStep& step) {
        return motion_batch(data, config, step.indices, source, step.seed, step.seed);
      },
      [forecast, device](const MotionBatch& b, const TrainStep&) mutable {
        const torch::Tensor error = (forecast(b.past) - b.future.to(device)).square().sum(3) + 1e-10;
        return Losses{{"joints", error.sqrt().mean()}};
      });
  task.validate = [&, forecast, source = no_contacts(config)]() mutable {
    return validated(validation, 1, [&](const std::vector<int64_t>& some) {
      const MotionBatch b = motion_batch(validation, config, some, source, 0, {});
      return (forecast(b.past).cpu() - b.future).norm(2, {3}).mean().item<double>();
    });
  };
  return task;
}

/// Copies the weights of a network of the same sizes; says nothing where the file has none.
template <class Network>
void adopt(Network& network, const Network& start, const std::string& prefix, const std::string& file) {
  if (start.is_empty()) return;
  SafeTensors content;
  nn::collect_parameters(*start, prefix, content);
  nn::load_parameters(*network, prefix, content, file);
  network->train();
}

}  // namespace

bool train(const TrainRun& run, const Config& config) {
  validate(config, run.out);
  const std::vector<std::string> names = chosen_stages(run.stages, {"contact", "motion", "no_contact", "adapt", "ltd"},
                                                       {"contact", "motion", "no_contact", "adapt"});
  const Config::Training& t = config.training;
  const Data data(run.data, "train", config, t.stride), adapt_data(run.data, "train", config, kAdaptStride),
      validation(run.data, "val", config, kValidationStride);
  if (data.size() == 0)
    throw Error(run.data.front(),
                "has no training window of " + std::to_string(config.past + config.future) + " frames");
  if (validation.size() == 0) throw Error(run.data.front(), "has no validation window");

  const Networks start = run.from.empty() ? Networks{} : load_networks(run.from);
  Networks model;
  model.config = config;
  const auto make_task = [&](const std::string& name) {
    if (name == "contact") {
      model.contact = ContactNetwork(config);
      adopt(model.contact, start.contact, "contact_net.", run.from);
      return contact_task(model, data, validation, run.device);
    }
    if (name == "ltd") {
      model.ltd = make_ltd(config);
      adopt(model.ltd, start.ltd, "ltd_net.", run.from);
      return ltd_task(model, data, validation, run.device);
    }
    if (name == "no_contact") {
      model.no_contact = MotionNetwork(config, /*with_contact=*/false);
      adopt(model.no_contact, start.no_contact, "no_contact_net.", run.from);
    } else {
      model.motion = MotionNetwork(config);
      adopt(model.motion, start.motion, "motion_net.", run.from);
    }
    if (name == "adapt") {
      const Networks before = std::filesystem::exists(run.out) ? load_networks(run.out) : Networks{};
      if (before.contact.is_empty() || before.motion.is_empty())
        throw Error(run.out, "lacks the contact or the motion network that stage adapt goes on from");
      model.contact = before.contact;
      model.motion = before.motion;
    }
    return motion_task(name, model, name == "adapt" ? adapt_data : data, validation, run.device);
  };
  std::vector<TrainStage> stages;
  for (const std::string& name : names) {
    const bool contact = name == "contact", adapt = name == "adapt";
    TrainStage stage{name,
                     contact ? t.contact_steps
                     : adapt ? t.adapt_steps
                             : t.motion_steps,
                     contact ? t.contact_batch : t.motion_batch,
                     contact ? t.contact_rate : t.motion_rate,
                     t.schedule,
                     12,
                     [&, name] { return make_task(name); }};
    if (stage.steps == 0)
      stage.steps = (adapt ? 10 : 50) *
                    std::max<int64_t>(1, (adapt ? adapt_data : data).size() / std::max<int64_t>(1, stage.batch));
    stages.push_back(stage);
  }
  return run_stages(stages, model_header(config), run);
}

}  // namespace inhabit::forecast
