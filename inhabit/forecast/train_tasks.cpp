#include "inhabit/forecast/train_tasks.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "inhabit/forecast/features.h"
#include "inhabit/forecast/hypotheses.h"
#include "inhabit/forecast/losses.h"
#include "inhabit/forecast/motion_batch.h"
#include "inhabit/metrics/forecast_error.h"

namespace inhabit::forecast {
namespace {

constexpr int64_t kValidationWindows = 192;
// Of the articulated network: decays of its weights' moving average and of the weights (AdamW).
constexpr double kAverage = 0.999, kWeightDecay = 0.01;
constexpr double kOthers = 0.03, kLikely = 0.02;  // of hypotheses that are not nearest; of their log-probabilities

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

/// The windows of a batch: those of its indices, or in their places windows of recordings and generated ones by the
/// fraction that config.training.recorded gives the former.
std::vector<int64_t> windows_of(const TrainStep& step, const Data& data, double recorded) {
  const WindowKinds& kinds = data.kinds();
  if (recorded <= 0 || kinds.recorded.empty() || kinds.generated.empty()) return step.indices;
  std::vector<int64_t> out;
  for (size_t i = 0; i < step.indices.size(); ++i) {
    const auto place = static_cast<double>(i);
    const bool real = std::floor((place + 1) * recorded) > std::floor(place * recorded);
    const std::vector<int64_t>& some = real ? kinds.recorded : kinds.generated;
    out.push_back(some[static_cast<size_t>(step.indices[i]) % some.size()]);
  }
  return out;
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

/// Batches whose windows have no contact points, and their losses.
template <class LossesOf>
auto without_contacts(const Data& data, const Config& config, LossesOf losses) {
  return batches(
      [&, source = no_contacts(config)](const TrainStep& step) {
        return motion_batch(data, config, windows_of(step, data, config.training.recorded), source, step.seed,
                            step.seed);
      },
      [losses](const MotionBatch& b, const TrainStep&) mutable { return losses(b); });
}

/// The mean joint error in the world, metres, of what `forecast` makes of validation windows: joints (B, T, J, 3).
std::function<double()> joint_error_of(const Data& validation, const Config& config,
                                       std::function<torch::Tensor(const MotionBatch&)> forecast) {
  return [&, forecast = std::move(forecast), source = no_contacts(config)] {
    return validated(validation, 32, [&](const std::vector<int64_t>& some) {
      const MotionBatch b = motion_batch(validation, config, some, source, 0, {});
      return (forecast(b).cpu() - b.future).norm(2, {3}).mean({1, 2}).sum().item<double>();
    });
  };
}

/// The sum over a batch's windows of path plus pose error, metres.
double summed_error(const torch::Tensor& joints, const torch::Tensor& future, int root) {
  return (path_error(joints, future, root).mean(1) + pose_error(joints, future, root).mean(1)).sum().item<double>();
}

}  // namespace

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
  task.concurrent = true;
  task.prepare = batches(
      [&](const TrainStep& step) {
        return contact_batch(data, config, windows_of(step, data, config.training.recorded), step.seed, true);
      },
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

TrainTask motion_task(const std::string& stage, Networks& model, const Data& data, const Data& validation,
                      torch::Device device) {
  const Config& config = model.config;
  MotionNetwork network = stage == "no_contact" ? model.no_contact : model.motion;
  const bool adapt = stage == "adapt";
  // Preparing runs beside validation, so that each has its own contact network.
  const auto contacts = [&] {
    if (adapt) return predicted_contacts(config, model.contact);
    return stage == "motion" ? true_contacts(config) : no_contacts(config);
  };
  TrainTask task;
  task.module = network.ptr();
  task.networks = {{stage == "no_contact" ? "no_contact_net." : "motion_net.", network.ptr()}};
  task.samples = data.size();
  task.prepare = batches(
      [&, adapt, source = adapt ? every_other_true(config, contacts()) : contacts()](const TrainStep& step) {
        return motion_batch(data, config, windows_of(step, data, config.training.recorded), source,
                            adapt ? 0 : step.seed, step.seed);
      },
      [&config, network, device](const MotionBatch& on_cpu, const TrainStep&) mutable {
        const MotionBatch b = on_cpu.on(device);
        const MotionLosses l = motion_losses(network->forward(b.past, b.contacts), b.future, b.contacts, config);
        return Losses{{"total", l.total}, {"root", l.root}, {"local", l.local}, {"contact", l.contact}};
      });
  task.validate = [&, network, source = contacts(), device]() mutable {
    return validated(validation, 32, [&](const std::vector<int64_t>& some) {
      const MotionBatch b = motion_batch(validation, config, some, source, 0, {});
      return summed_error(
          forecast_joints(network->forward(b.past.to(device), b.contacts.to(device)), config.root).cpu(), b.future,
          config.root);
    });
  };
  return task;
}

TrainTask articulated_task(Networks& model, const Data& data, const Data& validation, torch::Device device) {
  const Config& config = model.config;
  ArticulatedNetwork network = model.articulated;
  TrainTask task;
  task.module = network.ptr();
  task.networks = {{"articulated_net.", network.ptr()}, {"contact_net.", model.contact.ptr()}};
  task.outdated = {"hypotheses_net."};  // they differ from what this network said
  task.samples = data.size();
  task.average = kAverage;
  task.weight_decay = kWeightDecay;
  task.prepare = batches(
      [&, source = mixed_contacts(config, predicted_contacts(config, model.contact))](const TrainStep& step) {
        return motion_batch(data, config, windows_of(step, data, config.training.recorded), source, 0, step.seed,
                            /*truth=*/true);
      },
      [&config, network, device](const MotionBatch& on_cpu, const TrainStep&) mutable {
        const MotionBatch b = on_cpu.on(device);
        const ArticulatedLosses l = articulated_losses(network->forward(b.past, b.contacts, b.conditioning),
                                                       b.past.select(1, config.past - 1), b.future, b.truth, config);
        return Losses{
            {"total", l.total}, {"path", l.path}, {"pose", l.pose}, {"contact", l.contact}, {"velocity", l.velocity}};
      });
  task.validate = [&, network, source = predicted_contacts(config, model.contact), device]() mutable {
    return validated(validation, 32, [&](const std::vector<int64_t>& some) {
      const MotionBatch b = motion_batch(validation, config, some, source, 0, {}).on(device);
      return summed_error(forecast_joints(network->forward(b.past, b.contacts, b.conditioning), config.root).cpu(),
                          b.future.cpu(), config.root);
    });
  };
  return task;
}

TrainTask hypotheses_task(Networks& model, const Data& data, const Data& validation, torch::Device device) {
  const Config& config = model.config;
  HypothesesNetwork network = model.hypotheses;
  ArticulatedNetwork articulated = model.articulated;
  articulated->to(device);
  const std::function<Hypotheses(const MotionBatch&)> hypotheses = [network,
                                                                    articulated](const MotionBatch& b) mutable {
    ArticulatedNetworkImpl::Seen seen;
    {
      const torch::NoGradGuard no_gradients;
      seen = articulated->see(b.past, b.contacts, b.conditioning);
    }
    return network->forward(articulated, seen);
  };
  TrainTask task;
  task.module = network.ptr();
  task.networks = {{"hypotheses_net.", network.ptr()}};
  task.samples = data.size();
  task.average = kAverage;
  task.weight_decay = kWeightDecay;
  task.prepare = batches(
      [&, source = predicted_contacts(config, model.contact)](const TrainStep& step) {
        return motion_batch(data, config, windows_of(step, data, config.training.recorded), source, 0, step.seed);
      },
      [&config, hypotheses, device](const MotionBatch& on_cpu, const TrainStep&) mutable {
        const MotionBatch b = on_cpu.on(device);
        const Hypotheses found = hypotheses(b);
        const torch::Tensor errors =
            hypothesis_errors(found.joints, b.past.select(1, config.past - 1), b.future, config);
        const auto [least, nearest] = errors.min(1, true);
        const torch::Tensor distance = (1 - kOthers) * least.mean() + kOthers * errors.mean();
        const torch::Tensor likely = -found.log_probability.gather(1, nearest).mean();
        return Losses{{"total", distance + kLikely * likely}, {"nearest", least.mean()}, {"likely", likely}};
      });
  task.validate = [&, hypotheses, source = predicted_contacts(config, model.contact), device]() mutable {
    return validated(validation, 32, [&](const std::vector<int64_t>& some) {
      const MotionBatch b = motion_batch(validation, config, some, source, 0, {}).on(device);
      return hypothesis_errors(hypotheses(b).joints, b.past.select(1, config.past - 1), b.future, config)
          .amin(1)
          .sum()
          .item<double>();
    });
  };
  return task;
}

TrainTask baseline_task(const Baseline& baseline, const Config& config, const Data& data, const Data& validation,
                        torch::Device device) {
  const auto forecast = [joints = baseline.forecast, device](const MotionBatch& b) {
    return joints(b.past.to(device), b.points.to(device));
  };
  TrainTask task;
  task.module = baseline.network;
  task.networks = {{baseline.stage + "_net.", task.module}};
  task.samples = data.size();
  task.concurrent = true;
  task.prepare = without_contacts(data, config, [forecast, device](const MotionBatch& b) {
    const torch::Tensor error = (forecast(b) - b.future.to(device)).square().sum(3) + 1e-10;
    return Losses{{"joints", error.sqrt().mean()}};
  });
  task.validate = joint_error_of(validation, config, forecast);
  return task;
}

TrainTask slt_task(const Baseline& baseline, SltNetwork network, const Config& config, const Data& data,
                   const Data& validation, torch::Device device) {
  TrainTask task = baseline_task(baseline, config, data, validation, device);
  task.prepare = without_contacts(data, config, [&config, network, device](const MotionBatch& on_cpu) mutable {
    const MotionBatch b = on_cpu.on(device);
    const SltForecast f = network->forward(b.past, b.points);
    const torch::Tensor path = b.future.select(2, config.root), local = b.future - path.unsqueeze(2);
    const auto error = [](const torch::Tensor& x, const torch::Tensor& y) { return (x - y).abs().mean(); };
    const torch::Tensor goal = error(f.goal, path.select(1, config.future - 1)),
                        goal_pose = error(f.goal_pose, local.select(1, config.future - 1)), along = error(f.path, path),
                        poses = error(f.local, local);
    return Losses{{"total", goal + goal_pose + along + poses},
                  {"goal", goal},
                  {"goal_pose", goal_pose},
                  {"path", along},
                  {"poses", poses}};
  });
  return task;
}

}  // namespace inhabit::forecast
