#include "inhabit/interact/train.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>

#include "inhabit/error.h"
#include "inhabit/interact/losses.h"
#include "inhabit/interact/model_file.h"
#include "inhabit/interact/train_frames.h"

namespace inhabit::interact {
namespace {

constexpr int64_t kSeatedStays = 256, kStandingStays = 128;  // that a model file keeps
constexpr int64_t kEpochs = 150, kValidationContacts = 2048, kValidationSequences = 128;

ControlSequences on(const ControlSequences& s, torch::Device d) {
  return {s.pose.to(d), s.control.to(d), s.target.to(d), s.wanted.to(d), s.rotation.to(d), s.again.to(d)};
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
  task.concurrent = true;
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
                                                                                              double weight) mutable {
    const torch::Tensor noise = torch::randn({rows.contacts.size(0), t.model.config.contact_z}).to(t.device);
    return contact_losses(network, {rows.chair.to(t.device), rows.contacts.to(t.device)},
                          network->is_training() ? noise : torch::zeros_like(noise), weight * beta);
  };
  TrainTask task;
  task.module = network.ptr();
  task.networks = {{"contact_net.", network.ptr()}};
  task.samples = t.data.contact_sets();
  task.concurrent = true;
  task.prepare =
      batches([&t](const TrainStep& step) { return t.data.contact_rows(step.indices); },
              [losses, steps](const ContactRows& rows, const TrainStep& step) {
                const ContactLosses l =
                    losses(rows, std::min(1.0, 2.0 * static_cast<double>(step.number) / static_cast<double>(steps)));
                return Losses{{"total", l.total}, {"distance", l.distance}, {"divergence", l.divergence}};
              });
  task.validate = [&t, losses] {
    return validated(t.validation.contact_sets(), kValidationContacts, [&](const std::vector<int64_t>& some) {
      return losses(t.validation.contact_rows(some), 1).total.item<double>();
    });
  };
  return task;
}

TrainTask task_of(const std::string& name, Training& t, const Networks& start, const std::string& from, int64_t steps) {
  Networks& m = t.model;
  const Config& c = m.config;
  const std::string prefix = name + "_net.";
  for (const Predictor predictor : kPredictors)
    for (const bool rollouts : {false, true})
      if (name == (rollouts ? rollout_stage(predictor) : name_of(predictor)))
        return frame_task(predictor, rollouts, t, start, from);
  if (name == "control") {
    m.control = begun(start.control, prefix, from, [&] { return ControlNetwork(c); });
    m.control->to(t.device);
    return control_task(t, steps);
  }
  m.contact = begun(start.contact, prefix, from, [&] { return ContactNetwork(c); });
  m.contact->to(t.device);
  return contact_task(t, steps);
}

/// "pose" of "rollout", "nsm" of "nsm_rollout".
std::string network_of_stage(const std::string& stage) {
  for (const Predictor predictor : kPredictors)
    if (stage == rollout_stage(predictor)) return name_of(predictor);
  return stage;
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
  if (name.ends_with("rollout")) {
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
      chosen_stages(run.stages,
                    {"pose", "rollout", "control", "contact", "nsm", "nsm_rollout", "nsm_control",
                     "nsm_control_rollout", "samp", "samp_rollout", "samp_control", "samp_control_rollout"},
                    {"pose", "rollout", "control", "contact"});
  Training t(run, config);
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
  const bool goes_on =
      std::any_of(kPredictors.begin(), kPredictors.end(), [&](Predictor p) { return holds(start, p); });
  std::tie(t.input, t.output) = goes_on ? std::pair(start.input_scale, start.output_scale) : t.data.scales();
  std::vector<TrainStage> stages;
  for (const std::string& name : names) {
    TrainStage stage = stage_of(name, config.training, t);
    stage.task = [&t, &start, &run, name, steps = stage.steps] { return task_of(name, t, start, run.from, steps); };
    stages.push_back(std::move(stage));
  }
  // Networks of --from that are not trained stay in the file beside those that are.
  Networks kept = start;
  kept.config = config;
  kept.input_scale = t.input;
  kept.output_scale = t.output;
  const auto moves = [&](const std::string& name) { return name == "pose" || name == "rollout"; };
  if (!config.seated_habits)
    kept.habits = {};
  else if (kept.habits.seated.size() == 0 || std::any_of(names.begin(), names.end(), moves))
    kept.habits = habits_of(t.data, kSeatedStays, kStandingStays);
  std::vector<std::string> trained;
  trained.reserve(names.size());
  for (const std::string& name : names) trained.push_back(network_of_stage(name));
  return run_stages(stages, model_content(kept, trained), run, completed_by(config_from_json));
}

}  // namespace inhabit::interact
