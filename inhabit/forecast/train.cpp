#include "inhabit/forecast/train.h"

#include <algorithm>
#include <filesystem>

#include "inhabit/body/skeleton.h"
#include "inhabit/error.h"
#include "inhabit/forecast/train_tasks.h"
#include "inhabit/nn/parameters.h"

namespace inhabit::forecast {
namespace {

// A stage that keeps a prediction of each of its windows has fewer: some 15,000 of 200 minutes, which take 150 MB.
constexpr int64_t kSparseStride = 15, kValidationStride = 30;

bool is_articulated(const Config& config) { return config.decoder == "articulated"; }

bool among(const std::vector<std::string>& names, const char* name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

const std::vector<std::string>& baseline_stages() {
  static const std::vector<std::string> stages = {"ltd", "hisrep", "dmgnn", "slt"};
  return stages;
}

/// The stages of a run, in order.
std::vector<std::string> stages_of(const TrainRun& run, const Config& config) {
  std::vector<std::string> usual = {"contact", "motion"};
  if (is_articulated(config) && config.articulated.hypotheses > 0) usual.emplace_back("hypotheses");
  if (!is_articulated(config)) usual.insert(usual.end(), {"no_contact", "adapt"});
  std::vector<std::string> asked = run.stages;
  if (asked == std::vector<std::string>{"both"}) asked = {"contact", "motion"};
  if (asked == std::vector<std::string>{"all"}) {
    asked = usual;
    asked.insert(asked.end(), baseline_stages().begin(), baseline_stages().end());
  }
  std::vector<std::string> all = is_articulated(config)
                                     ? std::vector<std::string>{"contact", "motion", "hypotheses"}
                                     : std::vector<std::string>{"contact", "motion", "no_contact", "adapt"};
  all.insert(all.end(), baseline_stages().begin(), baseline_stages().end());
  std::vector<std::string> names = chosen_stages(asked, all, usual);
  if (among(names, "hypotheses") && config.articulated.hypotheses == 0)
    throw Error("articulated.hypotheses", "is 0: there are none to be trained");
  return names;
}

/// Gives sizes of one baseline to others.
using TakeSizes = void (*)(const Config::Baselines& from, Config::Baselines& to);
void take_ltd(const Config::Baselines& from, Config::Baselines& to) {
  to.ltd_hidden = from.ltd_hidden;
  to.ltd_blocks = from.ltd_blocks;
}
void take_hisrep(const Config::Baselines& from, Config::Baselines& to) {
  to.hisrep_query = from.hisrep_query;
  to.hisrep_future = from.hisrep_future;
  to.hisrep_hidden = from.hisrep_hidden;
  to.hisrep_blocks = from.hisrep_blocks;
}
void take_dmgnn(const Config::Baselines& from, Config::Baselines& to) { to.dmgnn_width = from.dmgnn_width; }
void take_slt(const Config::Baselines& from, Config::Baselines& to) {
  to.slt_goal = from.slt_goal;
  to.slt_path = from.slt_path;
  to.slt_pose = from.slt_pose;
}

/// Whether a baseline has the same sizes in both.
bool same_sizes(TakeSizes take, const Config& a, const Config& b) {
  Config::Baselines taken = b.baselines;
  take(a.baselines, taken);
  return taken == b.baselines;
}

/// A configuration in which baselines that come along from --from have the sizes that they have there.
Config with_kept_baselines(Config config, const Networks& start, const std::vector<std::string>& trained) {
  if (!start.ltd.is_empty() && !among(trained, "ltd")) take_ltd(start.config.baselines, config.baselines);
  if (!start.hisrep.is_empty() && !among(trained, "hisrep")) take_hisrep(start.config.baselines, config.baselines);
  if (!start.dmgnn.is_empty() && !among(trained, "dmgnn")) take_dmgnn(start.config.baselines, config.baselines);
  if (!start.slt.is_empty() && !among(trained, "slt")) take_slt(start.config.baselines, config.baselines);
  return config;
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

/// Puts the networks of --from that are not trained into a new file, beside those that are; of the same sizes alone.
void keep_untrained(const Networks& start, const Config& config, const std::vector<std::string>& trained,
                    SafeTensors& header) {
  Config sizes = start.config;
  sizes.preset = config.preset;
  sizes.training = config.training;
  sizes.baselines = config.baselines;
  sizes.articulated.hypotheses = config.articulated.hypotheses;
  if (!(sizes == config)) return;
  const auto keep = [&](const auto& network, const std::string& prefix, std::initializer_list<const char*> stages) {
    const bool anew =
        std::any_of(stages.begin(), stages.end(), [&](const char* stage) { return among(trained, stage); });
    if (!network.is_empty() && !anew) nn::collect_parameters(*network, prefix, header);
  };
  keep(start.contact, "contact_net.", {"contact"});
  keep(start.motion, "motion_net.", {"motion", "adapt"});
  keep(start.articulated, "articulated_net.", {"motion"});
  keep(start.no_contact, "no_contact_net.", {"no_contact"});
  if (start.config.articulated.hypotheses == config.articulated.hypotheses)
    keep(start.hypotheses, "hypotheses_net.", {"hypotheses", "motion"});
  keep(start.ltd, "ltd_net.", {"ltd"});
  keep(start.hisrep, "hisrep_net.", {"hisrep"});
  keep(start.dmgnn, "dmgnn_net.", {"dmgnn"});
  keep(start.slt, "slt_net.", {"slt"});
}

/// The networks of a run, stage by stage, and where the weights of each come from.
class Stages {
 public:
  Stages(const Stages&) = delete;  // its stages know where it is
  Stages& operator=(const Stages&) = delete;
  Stages(const TrainRun& run, const Config& config, std::vector<std::string> names, Networks start)
      : run_(run),
        config_(config),
        names_(std::move(names)),
        data_(run.data, "train", config, config.training.stride),
        sparse_data_(run.data, "train", config, kSparseStride),
        validation_(run.data, "val", config, kValidationStride),
        start_(std::move(start)) {
    model_.config = config;
    if (data_.size() == 0)
      throw Error(run.data.front(),
                  "has no training window of " + std::to_string(config.past + config.future) + " frames");
    if (validation_.size() == 0) throw Error(run.data.front(), "has no validation window");
  }

  const Networks& start() const { return start_; }

  TrainStage stage(const std::string& name) {
    const Config::Training& t = config_.training;
    const bool contact = name == "contact", adapt = name == "adapt";
    TrainStage out;
    out.name = name;
    out.steps = contact                ? t.contact_steps
                : adapt                ? t.adapt_steps
                : name == "hypotheses" ? t.hypotheses_steps
                                       : t.motion_steps;
    out.batch = contact ? t.contact_batch : t.motion_batch;
    out.learning_rate = contact ? t.contact_rate : t.motion_rate;
    out.schedule = t.schedule;
    if (out.steps == 0)
      out.steps = (adapt ? 10 : 50) * std::max<int64_t>(1, data_of(name).size() / std::max<int64_t>(1, out.batch));
    out.task = [this, name] { return task(name); };
    return out;
  }

 private:
  /// Whether a stage keeps a prediction of each of its windows.
  bool keeps_predictions(const std::string& name) const {
    return name == "adapt" || name == "hypotheses" || (is_articulated(config_) && name == "motion");
  }
  const Data& data_of(const std::string& name) const { return keeps_predictions(name) ? sparse_data_ : data_; }

  TrainTask task(const std::string& name) {
    if (name == "contact") {
      model_.contact = ContactNetwork(config_);
      adopt(model_.contact, start_.contact, "contact_net.", run_.from);
      return contact_task(model_, data_, validation_, run_.device);
    }
    if (among(baseline_stages(), name.c_str())) return baseline(name);
    const Networks before = earlier_stages(name);
    if (keeps_predictions(name)) take_contact_network(name, before);
    if (name == "hypotheses") return hypotheses(before);
    if (is_articulated(config_)) {
      model_.articulated = ArticulatedNetwork(config_);
      adopt(model_.articulated, start_.articulated, "articulated_net.", run_.from);
      return articulated_task(model_, sparse_data_, validation_, run_.device);
    }
    if (name == "no_contact") {
      model_.no_contact = MotionNetwork(config_, /*with_contact=*/false);
      adopt(model_.no_contact, start_.no_contact, "no_contact_net.", run_.from);
    } else if (name == "adapt") {
      model_.motion = before.motion;
    } else {
      model_.motion = MotionNetwork(config_);
      adopt(model_.motion, start_.motion, "motion_net.", run_.from);
    }
    return motion_task(name, model_, data_of(name), validation_, run_.device);
  }

  /// A baseline's network, with the weights of --from where these are of the same sizes.
  template <class Network>
  void begin(Network& network, Network made, const Network& start, TakeSizes take, const std::string& name) {
    network = std::move(made);
    if (same_sizes(take, start_.config, config_)) adopt(network, start, name + "_net.", run_.from);
  }

  TrainTask baseline(const std::string& name) {
    if (name == "ltd") begin(model_.ltd, make_ltd(config_), start_.ltd, take_ltd, name);
    if (name == "hisrep") begin(model_.hisrep, make_hisrep(config_), start_.hisrep, take_hisrep, name);
    if (name == "dmgnn") begin(model_.dmgnn, DmgnnNetwork(config_), start_.dmgnn, take_dmgnn, name);
    if (name == "slt") begin(model_.slt, SltNetwork(config_), start_.slt, take_slt, name);
    for (const Baseline& b : baselines_of(model_))
      if (b.stage == name)
        return name == "slt" ? slt_task(b, model_.slt, config_, data_, validation_, run_.device)
                             : baseline_task(b, config_, data_, validation_, run_.device);
    throw Error("stage '" + name + "'", "is of no baseline");
  }

  /// What the model file holds by now, for stages that take it. A run of several stages begins the file anew, from the
  /// weights of --from.
  Networks earlier_stages(const std::string& name) const {
    const bool anew = !run_.resume && names_.size() > 1 && name == names_.front() && !run_.from.empty();
    return keeps_predictions(name) && !anew && std::filesystem::exists(run_.out) ? load_networks(run_.out) : Networks{};
  }

  void take_contact_network(const std::string& name, const Networks& before) {
    model_.contact = ContactNetwork(config_);
    const ContactNetwork& known = before.contact.is_empty() ? start_.contact : before.contact;
    if (known.is_empty() || (name == "adapt" && before.motion.is_empty()))
      throw Error(run_.out, name == "adapt" ? "lacks the contact or the motion network that stage adapt goes on from"
                                            : "lacks the contact network whose predictions stage " + name + " takes");
    adopt(model_.contact, known, "contact_net.", before.contact.is_empty() ? run_.from : run_.out);
    model_.contact->eval();
  }

  TrainTask hypotheses(const Networks& before) {
    const bool in_out = !before.articulated.is_empty();
    const ArticulatedNetwork& known = in_out ? before.articulated : start_.articulated;
    if (known.is_empty()) throw Error(run_.out, "lacks the motion network that stage hypotheses goes on from");
    model_.articulated = ArticulatedNetwork(config_);
    adopt(model_.articulated, known, "articulated_net.", in_out ? run_.out : run_.from);
    model_.articulated->eval();
    model_.hypotheses = HypothesesNetwork(config_);
    if (start_.config.articulated.hypotheses == config_.articulated.hypotheses)
      adopt(model_.hypotheses, start_.hypotheses, "hypotheses_net.", run_.from);
    return hypotheses_task(model_, sparse_data_, validation_, run_.device);
  }

  const TrainRun& run_;
  const Config& config_;
  std::vector<std::string> names_;
  Data data_, sparse_data_, validation_;
  Networks start_, model_;
};

}  // namespace

bool train(const TrainRun& run, const Config& config) {
  validate(config, run.out);
  if (config.training.mirror && (config.joints != kStandardJoints || config.hips.empty()))
    throw Error("training.mirror", "needs the standard 22 joints, facing +Z");
  const std::vector<std::string> names = stages_of(run, config);
  Networks start = run.from.empty() ? Networks{} : load_networks(run.from);
  const Config own = with_kept_baselines(config, start, names);
  Stages all(run, own, names, std::move(start));
  std::vector<TrainStage> stages;
  stages.reserve(names.size());
  for (const std::string& name : names) stages.push_back(all.stage(name));
  SafeTensors header = model_header(own);
  if (!run.from.empty() && (names.size() > 1 || !std::filesystem::exists(run.out)))
    keep_untrained(all.start(), own, names, header);
  return run_stages(stages, header, run, completed_by(config_from_json));
}

}  // namespace inhabit::forecast
