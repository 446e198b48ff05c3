#include "inhabit/train/stages.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "inhabit/error.h"
#include "inhabit/nn/parameters.h"

namespace inhabit {
namespace {

// Steps between validations, at most: a long training that is interrupted has a best model by then.
constexpr int64_t kValidateEvery = 500;

std::string checkpoint_of(const std::string& out) { return out + ".checkpoint.safetensors"; }

/// The stage that a run starts with: the first, or, resumed, that of the checkpoint.
size_t first_stage(const std::vector<TrainStage>& stages, const TrainRun& run) {
  if (!run.resume) return 0;
  const auto state = read_safetensors_metadata(checkpoint_of(run.out));
  const auto of = state.find("run");
  const std::string name = of == state.end() ? "" : of->second.substr(0, of->second.find(' '));
  const auto found = std::find_if(stages.begin(), stages.end(), [&](const auto& s) { return s.name == name; });
  if (found == stages.end()) throw Error(checkpoint_of(run.out), "is not a checkpoint of the stages asked for");
  return static_cast<size_t>(found - stages.begin());
}

/// Whether two tensors are the same but for rounding (of files in half precision too).
bool alike(const torch::Tensor& a, const torch::Tensor& b) {
  return a.sizes() == b.sizes() && a.to(torch::kFloat32).allclose(b.to(torch::kFloat32), 1e-2, 1e-3);
}

/// A configuration without how it is trained and used, which may differ from stage to stage.
nlohmann::json architecture(const std::string& config) {
  nlohmann::json root = nlohmann::json::parse(config, nullptr, /*allow_exceptions=*/false);
  if (root.is_object())
    for (const char* group : {"training", "inference"}) root.erase(group);
  return root;
}

/// What the model file holds already. Throws Error where it belongs to another configuration.
SafeTensors kept_content(const SafeTensors& header, const std::string& path, const CompleteConfig& complete) {
  SafeTensors kept = read_safetensors(path);
  const bool same_system = kept.metadata["system"] == header.metadata.at("system");
  if (same_system && complete) kept.metadata["config"] = complete(kept.metadata["config"], path);
  if (!same_system || architecture(kept.metadata["config"]) != architecture(header.metadata.at("config")))
    throw Error(path, "holds networks of another configuration");
  kept.metadata = header.metadata;
  for (const auto& [name, tensor] : header.tensors)
    if (const auto found = kept.tensors.find(name); found != kept.tensors.end() && !alike(found->second, tensor))
      throw Error(path, "holds networks that were trained on other data (" + name + " differs)");
  return kept;
}

/// Puts what the task makes into the file's content.
void put(const TrainTask& task, SafeTensors& content) {
  const auto erase = [&](const std::string& prefix) {
    std::erase_if(content.tensors, [&](const auto& entry) { return entry.first.starts_with(prefix); });
  };
  for (const std::string& prefix : task.outdated) erase(prefix);
  for (const auto& [prefix, module] : task.networks) {
    erase(prefix);
    nn::collect_parameters(*module, prefix, content);
  }
  for (const auto& [name, tensor] : task.tensors) content.tensors[name] = tensor;
}

}  // namespace

std::vector<std::string> chosen_stages(const std::vector<std::string>& asked, const std::vector<std::string>& stages,
                                       const std::vector<std::string>& usual) {
  if (asked.empty()) return usual;
  std::vector<std::string> out;
  for (const std::string& stage : stages)
    if (std::find(asked.begin(), asked.end(), stage) != asked.end()) out.push_back(stage);
  for (const std::string& name : asked)
    if (std::find(stages.begin(), stages.end(), name) == stages.end()) {
      std::string there;
      for (const std::string& stage : stages) there += (there.empty() ? "" : ", ") + stage;
      throw Error("stage '" + name + "'", "is unknown; there are " + there);
    }
  return out;
}

bool run_stages(const std::vector<TrainStage>& stages, const SafeTensors& header, const TrainRun& run,
                const CompleteConfig& complete) {
  const size_t first = first_stage(stages, run);
  const bool anew = stages.size() > 1 && !run.resume;
  for (size_t s = first; s < stages.size(); ++s) {
    const TrainStage& stage = stages[s];
    if (run.ranks) run.ranks->wait_for_all();  // rank 0 has written what the stage before made
    SafeTensors content = header;
    if (std::filesystem::exists(run.out) && !(anew && s == first)) {
      content = kept_content(header, run.out, complete);
      for (const auto& [name, tensor] : header.tensors) content.tensors[name] = tensor;
    }
    torch::manual_seed(run.seed);
    TrainTask task = stage.task();
    task.name = stage.name;
    task.module->to(run.device);
    task.on_best = [&] {
      put(task, content);
      write_safetensors(run.out, content, run.half);
    };
    TrainOptions options;
    options.steps = stage.steps;
    options.batch = stage.batch;
    options.learning_rate = stage.learning_rate;
    options.schedule = stage.schedule;
    options.validate_every = std::clamp<int64_t>(stage.steps / stage.validations, 1, kValidateEvery);
    options.seed = run.seed;
    options.ranks = run.ranks;
    options.workers = run.workers;
    options.last = run.last;
    options.listener = run.listener;
    if (run.progress) options.progress = run.progress(stage.name);
    options.resume = run.resume && s == first;
    options.checkpoint = checkpoint_of(run.out);
    options.log = run.out + ".log.jsonl";
    options.append_log = s > 0 || options.resume;
    if (train(task, options).interrupted) return false;
  }
  return true;
}

}  // namespace inhabit
