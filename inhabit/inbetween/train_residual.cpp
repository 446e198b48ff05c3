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
  const std::vector<std::string> all = {"denoiser", "deployed", "path"};
  return chosen_stages(run.stages, all, all);
}

/// The configuration of a run that trains PathNet alone: the file's denoiser stays as it is.
Config of_path_alone(const Config& file, const Config& config) {
  Config out = file;
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
    if (run.from.empty() && (!moves || (names_.front() != "denoiser" && !run.resume)))
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
    networks_.config = moves ? config : of_path_alone(start_->config, config);
    networks_.residual_table = start_ ? start_->residual_table : residual_table(*data_, config, run.seed);
    schedule_ = cosine_schedule(config.diffusion_steps);
  }

  /// With the networks of --from that are not trained, which stay in the file beside those that are.
  SafeTensors header() const {
    SafeTensors out = model_header(networks_);
    if (start_ && names_.front() == "path") nn::collect_parameters(*start_->network, "net.", out);
    if (start_ && start_->path && names_.back() != "path") nn::collect_parameters(*start_->path, "path.", out);
    return out;
  }

  std::vector<TrainStage> stages() {
    const Config::Training& t = config_.training;
    std::vector<TrainStage> out;
    out.reserve(names_.size());
    for (const std::string& name : names_) {
      if (name == "denoiser")
        out.push_back(
            {name, t.steps, t.batch, t.learning_rate, t.schedule, kValidations, [this] { return denoiser(); }});
      else if (name == "deployed")
        out.push_back({name, t.deployed_steps, t.batch / 2, t.deployed_learning_rate, t.schedule, kValidations,
                       [this] { return deployed(); }});
      else
        out.push_back({name, t.path_steps, t.path_batch, t.path_learning_rate, t.schedule, kValidations,
                       [this] { return path(); }});
    }
    return out;
  }

 private:
  TrainTask denoiser() {
    const auto once = [this](const PoseWindows& windows, size_t count, uint64_t seed) {
      return draw_batch(windows, config_, networks_.residual_table, count, seed);
    };
    return task(run_.from, once, denoising_losses);
  }

  TrainTask deployed() {
    const auto two = [this](const PoseWindows& windows, size_t count, uint64_t seed) {
      return twice(draw_batch(windows, config_, networks_.residual_table, count, seed), item_seed(seed, 1));
    };
    return task(names_.front() == "deployed" ? run_.from : run_.out, two, deployed_losses);
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

  /// Of the denoiser. @param from whose weights it begins with; empty: at random. @param draw its batches, of windows,
  /// their number and a seed. @param losses of a batch
  template <class Draw, class LossesOf>
  TrainTask task(const std::string& from, const Draw& draw, const LossesOf& losses) {
    networks_.network = Denoiser(config_);
    if (!from.empty()) nn::load_parameters(*networks_.network, "net.", read_safetensors(from), from);
    TrainTask out = denoiser_task(networks_, run_, data_->size());
    out.prepare = batches([this, draw](const TrainStep& step) { return draw(*data_, step.indices.size(), step.seed); },
                          [this, losses](const ResidualBatch& b, const TrainStep&) {
                            return losses(networks_, schedule_, b.to(run_.device), config_.training.bfloat16);
                          });
    out.validate = [this, draw, losses] {
      double sum = 0;
      for (int64_t i = 0; i < kValidationBatches; ++i) {
        const ResidualBatch b = draw(*validation_, 32, item_seed(run_.seed, static_cast<uint64_t>(i))).to(run_.device);
        sum += losses(networks_, schedule_, b, false).front().second.template item<double>();
      }
      return sum / kValidationBatches;
    };
    return out;
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
