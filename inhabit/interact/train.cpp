#include "inhabit/interact/train.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>

#include "inhabit/error.h"
#include "inhabit/interact/losses.h"
#include "inhabit/interact/model_file.h"
#include "inhabit/interact/rollout.h"
#include "inhabit/interact/sample.h"
#include "inhabit/nn/parameters.h"

namespace inhabit::interact {
namespace {

constexpr double kLost = 2;  // deviations: farther off, a rollout has got lost
constexpr int64_t kEpochs = 150, kValidationRows = 2048, kValidationSequences = 128;

/// What the stages of a run share.
struct Training {
  Networks model;
  Data data, validation;
  torch::Device device;
  FeatureScale input, output;  // on the CPU
};

/// Rows as PoseNet or one of the baselines takes them, standardised.
struct PoseBatch {
  torch::Tensor input, target;
};

enum class RowKind { pose, nsm, nsm_control };

PoseBatch pose_batch(const Training& t, const Data& data, RowKind kind, const std::vector<int64_t>& indices) {
  const torch::NoGradGuard no_grad;
  PoseRows rows = data.pose_rows(indices);
  rows.input.sub_(t.input.mean).div_(t.input.deviation);
  rows.target.sub_(t.output.mean).div_(t.output.deviation);
  if (kind == RowKind::pose) return {rows.input, rows.target};
  const InputLayout l = input_layout(t.model.config);
  std::vector<torch::Tensor> parts{rows.input.slice(1, 0, l.goals.end())};
  if (kind == RowKind::nsm_control) parts.push_back(rows.contacts);
  parts.push_back(rows.input.slice(1, l.ego.first, l.hands.first));
  parts.push_back(rows.input.slice(1, l.gating.first));
  return {torch::cat(parts, 1), rows.target};
}

/// The mean over evenly spread rows of the validation split of what `error` says of some of them.
double validated(int64_t size, int64_t count, const std::function<double(const std::vector<int64_t>&)>& error) {
  const std::vector<int64_t> rows = spread_indices(size, count);
  constexpr size_t kTogether = 128;
  double sum = 0;
  for (size_t first = 0; first < rows.size(); first += kTogether) {
    const size_t end = std::min(first + kTogether, rows.size());
    sum += static_cast<double>(end - first) *
           error({rows.begin() + static_cast<long>(first), rows.begin() + static_cast<long>(end)});
  }
  return sum / static_cast<double>(rows.size());
}

/// A task whose losses are those of rows: PoseNet's and the baselines'. `losses(batch)` on the training's device.
template <class Network>
TrainTask row_task(Training& t, Network network, const std::string& prefix, RowKind kind,
                   const std::function<Losses(const PoseBatch&)>& losses) {
  TrainTask task;
  task.module = network.ptr();
  task.networks = {{prefix, network.ptr()}};
  task.samples = t.data.poses();
  task.weight_decay = t.model.config.training.pose_decay;
  const auto moved = [&t](const PoseBatch& b) { return PoseBatch{b.input.to(t.device), b.target.to(t.device)}; };
  task.prepare = batches([&t, kind](const TrainStep& step) { return pose_batch(t, t.data, kind, step.indices); },
                         [losses, moved](const PoseBatch& b, const TrainStep&) { return losses(moved(b)); });
  task.validate = [&t, losses, moved, kind] {
    return validated(t.validation.poses(), kValidationRows, [&](const std::vector<int64_t>& some) {
      return losses(moved(pose_batch(t, t.validation, kind, some))).front().second.template item<double>();
    });
  };
  return task;
}

torch::Tensor rollout_error(const Training& t, const torch::Tensor& output, const torch::Tensor& target) {
  return frame_loss(output_layout(t.model.config), output, target, t.model.config.training.rollout_hand_weight, kLost);
}

TrainTask pose_task(Training& t, PoseNetwork network, const std::string& prefix, RowKind kind) {
  return row_task(t, network, prefix, kind, [network](const PoseBatch& b) mutable {
    return Losses{{"square", torch::mse_loss(network->forward(b.input), b.target)}};
  });
}

/// PoseNet on rows of its own rollouts, beside those of recordings that they begin with.
TrainTask rollout_task(Training& t, PoseNetwork network) {
  const int64_t frames = t.model.config.training.rollout_frames;
  const std::function<PoseBatch(const Data&, const std::vector<int64_t>&)> rows_of =
      [network, &t, frames](const Data& data, const std::vector<int64_t>& indices) mutable {
        const torch::NoGradGuard no_grad;
        const bool training = network->is_training();
        network->eval();
        PoseRows rows = rollout(data, indices, frames, [&](const torch::Tensor& input) {
          return t.output.from_network(network->forward(t.input.to_network(input).to(t.device)).cpu());
        });
        network->train(training);
        return PoseBatch{t.input.to_network(rows.input).to(t.device), t.output.to_network(rows.target).to(t.device)};
      };
  TrainTask task;
  task.module = network.ptr();
  task.networks = {{"pose_net.", network.ptr()}};
  task.samples = t.data.poses();
  task.weight_decay = t.model.config.training.pose_decay;
  task.average = t.model.config.training.rollout_average;
  // Rollouts are made with the weights of the step that learns from them, on its own thread.
  task.prepare = batches([](const TrainStep& step) { return step.indices; },
                         [network, rows_of, &t](const std::vector<int64_t>& indices, const TrainStep&) mutable {
                           const PoseBatch b = rows_of(t.data, indices);
                           return Losses{{"square", rollout_error(t, network->forward(b.input), b.target)}};
                         });
  task.validate = [network, rows_of, &t, frames]() mutable {
    return validated(t.validation.poses(), kValidationRows / frames, [&](const std::vector<int64_t>& some) {
      const PoseBatch b = rows_of(t.validation, some);
      return rollout_error(t, network->forward(b.input), b.target).item<double>();
    });
  };
  return task;
}

TrainTask samp_task(Training& t, SampNetwork network, const std::string& prefix, RowKind kind) {
  const double beta = t.model.config.baselines.samp_beta;
  return row_task(t, network, prefix, kind, [network, beta](const PoseBatch& b) mutable {
    const LatentDistribution z = network->encode(b.target, b.input);
    const torch::Tensor noise = network->is_training() ? torch::randn_like(z.mean) : torch::zeros_like(z.mean);
    const torch::Tensor square = torch::mse_loss(network->decode(z.sample(noise), b.input), b.target);
    const torch::Tensor divergence = z.divergence();
    return Losses{{"total", square + beta * divergence}, {"square", square}, {"divergence", divergence}};
  });
}

ControlSequences on(const ControlSequences& s, torch::Device d) {
  return {s.pose.to(d), s.control.to(d), s.target.to(d), s.wanted.to(d), s.turn.to(d), s.again.to(d)};
}

TrainTask control_task(Training& t, int64_t steps) {
  const Config::Training& settings = t.model.config.training;
  ControlNetwork network = t.model.control;
  const std::function<ControlLosses(const ControlSequences&, double)> losses =
      [network, &settings, &t](const ControlSequences& on_cpu, double own) mutable {
        const ControlSequences s = on(on_cpu, t.device);
        const ControlRun run = run_control(network, s, own);
        return control_losses(run.output, run.control, s.target, s.wanted, settings);
      };
  TrainTask task;
  task.module = network.ptr();
  task.networks = {{"control_net.", network.ptr()}};
  task.samples = t.data.sequences();
  task.prepare = batches([&t](const TrainStep& step) { return t.data.control_sequences(step.indices); },
                         [losses, &settings, steps](const ControlSequences& s, const TrainStep& step) {
                           const double done = static_cast<double>(step.number) / static_cast<double>(steps);
                           const double span = std::max(1e-9, settings.sampling_to - settings.sampling_from);
                           const ControlLosses l =
                               losses(s, std::clamp((done - settings.sampling_from) / span, 0., 1.));
                           return Losses{{"total", l.total},
                                         {"trajectory", l.trajectory},
                                         {"phase", l.phase},
                                         {"straight", l.straight},
                                         {"first", l.first}};
                         });
  task.validate = [&t, losses] {
    return validated(t.validation.sequences(), kValidationSequences, [&](const std::vector<int64_t>& some) {
      return losses(t.validation.control_sequences(some), 1).total.item<double>();
    });
  };
  return task;
}

/// The divergence counts more and more over the first half of the steps: from the start it would be cheaper to say
/// nothing by z.
TrainTask contact_task(Training& t, int64_t steps) {
  const double beta = t.model.config.training.contact_beta;
  ContactNetwork network = t.model.contact;
  const std::function<ContactLosses(const ContactRows&, double)> losses = [network, beta, &t](const ContactRows& rows,
                                                                                              double share) mutable {
    const torch::Tensor noise = torch::randn({rows.contacts.size(0), t.model.config.contact_z}).to(t.device);
    return contact_losses(network, {rows.chair.to(t.device), rows.contacts.to(t.device)},
                          network->is_training() ? noise : torch::zeros_like(noise), share * beta);
  };
  TrainTask task;
  task.module = network.ptr();
  task.networks = {{"contact_net.", network.ptr()}};
  task.samples = t.data.contact_sets();
  task.prepare =
      batches([&t](const TrainStep& step) { return t.data.contact_rows(step.indices); },
              [losses, steps](const ContactRows& rows, const TrainStep& step) {
                const ContactLosses l =
                    losses(rows, std::min(1.0, 2.0 * static_cast<double>(step.number) / static_cast<double>(steps)));
                return Losses{{"total", l.total}, {"distance", l.distance}, {"divergence", l.divergence}};
              });
  task.validate = [&t, losses] {
    return validated(t.validation.contact_sets(), kValidationRows, [&](const std::vector<int64_t>& some) {
      return losses(t.validation.contact_rows(some), 1).total.item<double>();
    });
  };
  return task;
}

/// A network, or the one that a run starts from.
template <class Network, class Make>
Network begun(const Network& start, const std::string& prefix, const std::string& file, const Make& make) {
  Network network = make();
  if (start.is_empty()) return network;
  SafeTensors content;
  nn::collect_parameters(*start, prefix, content);
  nn::load_parameters(*network, prefix, content, file);
  network->train();
  return network;
}

TrainTask task_of(const std::string& name, Training& t, const Networks& start, const std::string& from, int64_t steps) {
  Networks& m = t.model;
  const Config& c = m.config;
  const std::string prefix = name + "_net.";
  const auto pose_like = [&](PoseNetwork& network, const PoseNetwork& first, const PoseSizes& sizes, RowKind kind) {
    network = begun(first, prefix, from, [&] { return PoseNetwork(sizes); });
    network->to(t.device);
    return pose_task(t, network, prefix, kind);
  };
  const auto samp_like = [&](SampNetwork& network, const SampNetwork& first, bool contacts) {
    network = begun(first, prefix, from, [&] { return SampNetwork(c, contacts); });
    network->to(t.device);
    return samp_task(t, network, prefix, contacts ? RowKind::nsm_control : RowKind::nsm);
  };
  if (name == "pose") return pose_like(m.pose, start.pose, pose_sizes(c), RowKind::pose);
  if (name == "rollout") {
    if (m.pose.is_empty()) m.pose = start.pose;  // a stage of its own goes on from --from
    if (m.pose.is_empty())
      throw Error("stage rollout", "goes on from a PoseNet: train stage pose first, or say --from");
    m.pose->to(t.device);
    m.pose->train();
    return rollout_task(t, m.pose);
  }
  if (name == "nsm") return pose_like(m.nsm, start.nsm, nsm_sizes(c, false), RowKind::nsm);
  if (name == "nsm_control")
    return pose_like(m.nsm_control, start.nsm_control, nsm_sizes(c, true), RowKind::nsm_control);
  if (name == "samp") return samp_like(m.samp, start.samp, false);
  if (name == "samp_control") return samp_like(m.samp_control, start.samp_control, true);
  if (name == "control") {
    m.control = begun(start.control, prefix, from, [&] { return ControlNetwork(c); });
    m.control->to(t.device);
    return control_task(t, steps);
  }
  m.contact = begun(start.contact, prefix, from, [&] { return ContactNetwork(c); });
  m.contact->to(t.device);
  return contact_task(t, steps);
}

TrainStage stage_of(const std::string& name, const Config::Training& s, const Training& t) {
  TrainStage stage;
  stage.name = name;
  stage.batch = s.batch;
  int64_t samples = t.data.poses();
  if (name == "control" || name == "contact") {
    const bool control = name == "control";
    samples = control ? t.data.sequences() : t.data.contact_sets();
    stage.steps = control ? s.control_steps : s.contact_steps;
    stage.learning_rate = control ? s.control_rate : s.contact_rate;
    stage.schedule = control ? s.control_schedule() : s.contact_schedule();
  } else {
    stage.steps = s.pose_steps;
    stage.learning_rate = s.pose_rate;
    stage.schedule = s.pose_schedule();
    stage.validations = 24;
  }
  if (name == "rollout") {
    stage.steps = s.rollout_steps;
    stage.learning_rate = s.rollout_rate;
    samples /= s.rollout_frames;
  }
  if (stage.steps == 0) stage.steps = kEpochs * std::max<int64_t>(1, samples / stage.batch);
  return stage;
}

}  // namespace

bool train(const TrainRun& run, const Config& config) {
  validate(config, run.out);
  require_window(config, "configuration");
  const std::vector<std::string> names =
      chosen_stages(run.stages, {"pose", "rollout", "control", "contact", "nsm", "nsm_control", "samp", "samp_control"},
                    {"pose", "rollout", "control", "contact"});
  Training t{{},
             Data(run.data, "train", config, config.training.mirrored),
             Data(run.data, "val", config, false),
             run.device,
             {},
             {}};
  if (t.data.poses() == 0) throw Error(run.data.front(), "has no training clip in a room with a chair");
  if (t.validation.poses() == 0) throw Error(run.data.front(), "has no validation clip in a room with a chair");
  for (const std::string& name : names)
    for (const Data* part : {&t.data, &t.validation})
      if ((name == "control" && part->sequences() == 0) || (name == "contact" && part->contact_sets() == 0))
        throw Error(run.data.front(), std::string("has no ") + (part == &t.data ? "training" : "validation") +
                                          " clip in which a hand reaches for something to touch, which stage " + name +
                                          " needs");
  spdlog::info("{} clips, {} frames, {} sequences, {} sets of contacts", t.data.clips(), t.data.poses(),
               t.data.sequences(), t.data.contact_sets());
  t.model.config = config;
  const Networks start = run.from.empty() ? Networks{} : load_networks(run.from);
  // Weights that are gone on with belong to the scales that they were trained with.
  if (start.pose.is_empty())
    std::tie(t.input, t.output) = t.data.scales();
  else
    std::tie(t.input, t.output) = std::pair(start.input_scale, start.output_scale);
  std::vector<TrainStage> stages;
  for (const std::string& name : names) {
    TrainStage stage = stage_of(name, config.training, t);
    stage.task = [&t, &start, &run, name, steps = stage.steps] { return task_of(name, t, start, run.from, steps); };
    stages.push_back(std::move(stage));
  }
  return run_stages(stages, model_header(config, t.input, t.output), run);
}

}  // namespace inhabit::interact
