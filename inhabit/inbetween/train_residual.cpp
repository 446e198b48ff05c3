#include "inhabit/inbetween/train_residual.h"

#include <optional>

#include "inhabit/error.h"
#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/residual_batch.h"
#include "inhabit/inbetween/residual_losses.h"
#include "inhabit/inbetween/train_path.h"
#include "inhabit/math/random.h"
#include "inhabit/nn/parameters.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

constexpr int64_t kValidationBatches = 6;

}  // namespace

bool train_residual(const TrainRun& run, const Config& config) {
  const std::vector<std::string> all = {"denoiser", "deployed", "path"};
  const std::vector<std::string> chosen = chosen_stages(run.stages, all, all);
  const bool moves = chosen.front() != "path";
  if (run.from.empty() && (!moves || (chosen.front() != all.front() && !run.resume)))
    throw Error("stage '" + chosen.front() + "'", "starts from the weights of a model: --from is missing");
  std::optional<PoseWindows> data, validation;
  if (moves) {
    data.emplace(run.data, "train", config, config.training.stride);
    validation.emplace(run.data, "val", config, config.frames);
    if (data->size() == 0 || validation->size() == 0)
      throw Error(run.data.front(), "has no window of " + std::to_string(config.frames) +
                                        " frames in a scene in its split " + (data->size() == 0 ? "train" : "val"));
  }
  Networks networks;
  networks.config = config;
  std::optional<Networks> start;
  if (!run.from.empty()) start = load_networks(run.from);
  if (start && !start->config.residual) throw Error(run.from, "is not of residual motion");
  if (start && !moves) {  // the file's denoiser stays as it is
    networks.config = start->config;
    Config::Training& t = networks.config.training;
    t.path_steps = config.training.path_steps;
    t.path_batch = config.training.path_batch;
    t.path_learning_rate = config.training.path_learning_rate;
    t.average = config.training.average;
    t.weight_decay = config.training.weight_decay;
    t.schedule = config.training.schedule;
    t.bfloat16 = config.training.bfloat16;
  }
  networks.residual_table = start ? start->residual_table : residual_table(*data, config, run.seed);
  SafeTensors header = model_header(networks);
  // Networks of --from that are not trained stay in the file beside those that are.
  if (start && !moves) nn::collect_parameters(*start->network, "net.", header);
  if (start && start->path && chosen.back() != "path") nn::collect_parameters(*start->path, "path.", header);
  const DiffusionSchedule schedule = cosine_schedule(config.diffusion_steps);
  // The weights that a stage starts from, and its batches and losses.
  const auto make_task = [&](const std::string& from, auto draw, auto losses) {
    networks.network = Denoiser(config);
    if (!from.empty()) nn::load_parameters(*networks.network, "net.", read_safetensors(from), from);
    TrainTask task;
    task.settings = to_json(config) + (run.from.empty() ? "" : " from " + run.from);
    task.average = config.training.average;
    task.weight_decay = config.training.weight_decay;
    task.module = networks.network.ptr();
    task.networks = {{"net.", networks.network.ptr()}};
    task.samples = data->size();
    task.prepare = batches([&, draw](const TrainStep& step) { return draw(*data, step.indices.size(), step.seed); },
                           [&, losses](const ResidualBatch& b, const TrainStep&) {
                             return losses(networks, schedule, b, config.training.bfloat16);
                           });
    task.validate = [&, draw, losses] {
      double sum = 0;
      for (int64_t i = 0; i < kValidationBatches; ++i)
        sum += losses(networks, schedule, draw(*validation, 32, item_seed(run.seed, static_cast<uint64_t>(i))), false)
                   .front()
                   .second.template item<double>();
      return sum / kValidationBatches;
    };
    return task;
  };
  const auto once = [&](const PoseWindows& windows, size_t count, uint64_t seed) {
    return draw_batch(windows, config, networks.residual_table, count, seed);
  };
  const auto two = [&](const PoseWindows& windows, size_t count, uint64_t seed) {
    return twice(once(windows, count, seed), item_seed(seed, 1));
  };
  const Config::Training& t = config.training;
  std::vector<TrainStage> stages;
  for (const std::string& name : chosen) {
    if (name == all.front())
      stages.push_back({name, t.steps, t.batch, t.learning_rate, t.schedule, 20,
                        [&] { return make_task(run.from, once, denoising_losses); }});
    else if (name == "path")
      stages.push_back({name, t.path_steps, t.path_batch, t.path_learning_rate, t.schedule, 20, [&] {
                          networks.path = PathNet();
                          if (start && start->path)
                            nn::load_parameters(*networks.path, "path.", read_safetensors(run.from), run.from);
                          networks.path->bfloat16 = t.bfloat16;
                          TrainTask task = path_task(networks.path, run.seed);
                          task.settings = to_json(config);
                          task.average = t.average;
                          task.weight_decay = t.weight_decay;
                          return task;
                        }});
    else
      stages.push_back({name, t.deployed_steps, t.batch / 2, t.deployed_learning_rate, t.schedule, 20, [&, name] {
                          return make_task(chosen.front() == name ? run.from : run.out, two, deployed_losses);
                        }});
  }
  return run_stages(stages, header, run);
}

}  // namespace inhabit::inbetween
