#include "inhabit/inbetween/train_residual.h"

#include <optional>

#include "inhabit/error.h"
#include "inhabit/inbetween/denoiser_task.h"
#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/residual_batch.h"
#include "inhabit/inbetween/residual_losses.h"
#include "inhabit/inbetween/train_path.h"
#include "inhabit/math/random.h"
#include "inhabit/nn/parameters.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

constexpr int64_t kValidationBatches = 6, kValidations = 20;

std::vector<std::string> stages_of(const TrainRun& run) {
  const std::vector<std::string> all = {"denoiser", "deployed", "contacts", "path"};
  return chosen_stages(run.stages, all, all);
}

/// The configuration of a run in which the file's denoiser stays as it is.
Config of_kept_denoiser(const Config& file, const Config& config) {
  Config out = file;
  out.training.contact_steps = config.training.contact_steps;
  out.training.contact_learning_rate = config.training.contact_learning_rate;
  out.training.path_steps = config.training.path_steps;
  out.training.path_batch = config.training.path_batch;
  out.training.path_learning_rate = config.training.path_learning_rate;
  out.training.average = config.training.average;
  out.training.weight_decay = config.training.weight_decay;
  out.training.schedule = config.training.schedule;
  out.training.bfloat16 = config.training.bfloat16;
  return out;
}

/// The networks of a run, stage by stage, and where the weights of each come from.
class Stages {
 public:
  Stages(const Stages&) = delete;  // its stages know where it is
  Stages& operator=(const Stages&) = delete;
  Stages(const TrainRun& run, const Config& config) : run_(run), config_(config), names_(stages_of(run)) {
    const bool moves = names_.front() != "path";
    if (run.from.empty() && (keeps_denoiser() || (names_.front() != "denoiser" && !run.resume)))
      throw Error("stage '" + names_.front() + "'", "starts from the weights of a model: --from is missing");
    if (moves) {
      data_.emplace(run.data, "train", config, config.training.stride);
      validation_.emplace(run.data, "val", config, config.frames);
      if (data_->size() == 0 || validation_->size() == 0)
        throw Error(run.data.front(), "has no window of " + std::to_string(config.frames) +
                                          " frames in a scene in its split " + (data_->size() == 0 ? "train" : "val"));
    }
    if (!run.from.empty()) start_ = load_networks(run.from);
    if (start_ && !start_->config.residual) throw Error(run.from, "is not of residual motion");
    networks_.config = keeps_denoiser() ? of_kept_denoiser(start_->config, config) : config;
    networks_.residual_table = start_ ? start_->residual_table : residual_table(*data_, config, run.seed);
    schedule_ = cosine_schedule(config.diffusion_steps);
  }

  /// With the networks of --from that are not trained, which stay in the file beside those that are.
  SafeTensors header() const {
    SafeTensors out = model_header(networks_);
    if (start_ && keeps_denoiser()) nn::collect_parameters(*start_->network, "net.", out);
    if (start_ && start_->path && names_.back() != "path") nn::collect_parameters(*start_->path, "path.", out);
    if (start_ && start_->feet && names_.front() == "path") nn::collect_parameters(*start_->feet, "feet.", out);
    return out;
  }

  std::vector<TrainStage> stages() {
    const Config::Training& t = config_.training;
    std::vector<TrainStage> out;
    out.reserve(names_.size());
    for (const std::string& name : names_) {
      const auto add = [&](int64_t steps, int64_t batch, double rate, TrainTask (Stages::*make)()) {
        out.push_back({name, steps, batch, rate, t.schedule, kValidations, [this, make] { return (this->*make)(); }});
      };
      if (name == "denoiser") add(t.steps, t.batch, t.learning_rate, &Stages::denoiser);
      if (name == "deployed") add(t.deployed_steps, t.batch / 2, t.deployed_learning_rate, &Stages::deployed);
      if (name == "contacts") add(t.contact_steps, t.batch / 2, t.contact_learning_rate, &Stages::contacts);
      if (name == "path") add(t.path_steps, t.path_batch, t.path_learning_rate, &Stages::path);
    }
    return out;
  }

 private:
  bool keeps_denoiser() const { return names_.front() == "contacts" || names_.front() == "path"; }

  /// The file that a stage finds the denoiser in: that of --from before this run has written one.
  const std::string& file_before(const char* stage) const { return names_.front() == stage ? run_.from : run_.out; }

  ResidualBatch once(const PoseWindows& windows, size_t count, uint64_t seed) const {
    return draw_batch(windows, networks_.config, networks_.residual_table, count, seed);
  }
  ResidualBatch two(const PoseWindows& windows, size_t count, uint64_t seed) const {
    return twice(once(windows, count, seed), item_seed(seed, 1));
  }

  TrainTask denoiser() {
    TrainTask out = task(run_.from);
    set_batches(out, &Stages::once, denoising_losses);
    return out;
  }

  TrainTask deployed() {
    TrainTask out = task(file_before("deployed"));
    set_batches(out, &Stages::two, deployed_losses);
    return out;
  }

  /// Of FootContactNet: the denoiser stays as it is.
  TrainTask contacts() {
    const std::string& from = file_before("contacts");
    TrainTask out = task(from);
    networks_.network->to(run_.device);
    networks_.feet = foot_contact_net(networks_.config);
    if (keeps_denoiser() && start_->feet) nn::load_parameters(*networks_.feet, "feet.", read_safetensors(from), from);
    out.module = networks_.feet.ptr();
    out.networks = {{"feet.", networks_.feet.ptr()}};
    out.outdated.clear();
    set_batches(out, &Stages::once, contact_losses);
    return out;
  }

  TrainTask path() {
    networks_.path = PathNet();
    if (start_ && start_->path) nn::load_parameters(*networks_.path, "path.", read_safetensors(run_.from), run_.from);
    networks_.path->bfloat16 = config_.training.bfloat16;
    TrainTask out = path_task(networks_.path, run_.seed, run_.device);
    out.settings = to_json(config_);
    out.average = config_.training.average;
    out.weight_decay = config_.training.weight_decay;
    return out;
  }

  /// Of the denoiser, without its batches. @param from whose weights it begins with; empty: at random
  TrainTask task(const std::string& from) {
    networks_.network = Denoiser(networks_.config);
    if (!from.empty()) nn::load_parameters(*networks_.network, "net.", read_safetensors(from), from);
    TrainTask out = denoiser_task(networks_, run_, data_->size());
    out.outdated = {"feet."};
    return out;
  }

  /// @param draw its batches, of windows, their number and a seed. @param losses of a batch
  void set_batches(TrainTask& out, ResidualBatch (Stages::*draw)(const PoseWindows&, size_t, uint64_t) const,
                   Losses (*losses)(const Networks&, const DiffusionSchedule&, const ResidualBatch&, bool)) {
    out.prepare =
        batches([this, draw](const TrainStep& step) { return (this->*draw)(*data_, step.indices.size(), step.seed); },
                [this, losses](const ResidualBatch& b, const TrainStep&) {
                  return losses(networks_, schedule_, b.to(run_.device), networks_.config.training.bfloat16);
                });
    out.validate = [this, draw, losses] {
      double sum = 0;
      for (int64_t i = 0; i < kValidationBatches; ++i) {
        const ResidualBatch b =
            (this->*draw)(*validation_, 32, item_seed(run_.seed, static_cast<uint64_t>(i))).to(run_.device);
        sum += losses(networks_, schedule_, b, false).front().second.item<double>();
      }
      return sum / kValidationBatches;
    };
  }

  const TrainRun& run_;
  const Config& config_;
  std::vector<std::string> names_;
  std::optional<PoseWindows> data_, validation_;
  std::optional<Networks> start_;
  Networks networks_;
  DiffusionSchedule schedule_;
};

}  // namespace

bool train_residual(const TrainRun& run, const Config& config) {
  Stages stages(run, config);
  const SafeTensors header = stages.header();
  return run_stages(stages.stages(), header, run, completed_by(config_from_json));
}

}  // namespace inhabit::inbetween
