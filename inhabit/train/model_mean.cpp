#include "inhabit/train/model_mean.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "inhabit/error.h"
#include "inhabit/io/json_text.h"

namespace inhabit {

using torch::Tensor;

namespace {

/// The configuration that a model file says it has, without how it was trained; null where it says none.
nlohmann::json sizes_of(const SafeTensors& model) {
  const auto config = model.metadata.find("config");
  if (config == model.metadata.end()) return {};
  if (nested_too_deep(config->second)) return nlohmann::json(nlohmann::json::value_t::discarded);
  auto fields = nlohmann::json::parse(config->second, nullptr, /*allow_exceptions=*/false);
  if (fields.is_object()) {
    fields.erase("training");
    if (fields.contains("residual")) fields.emplace("along_detours", false);  // files of before do not say
  }
  return fields;
}

/// Whether settings that both know are the same: one that came since has the value that was meant before it did.
bool agree(const nlohmann::json& a, const nlohmann::json& b) {
  if (!a.is_object() || !b.is_object()) return a == b;
  return std::all_of(a.items().begin(), a.items().end(), [&](const auto& item) {
    const auto other = b.find(item.key());
    return other == b.end() || agree(item.value(), *other);
  });
}

/// Whether a tensor is recorded motion (interact/habits.h), no weight: two files' have no mean.
bool is_recorded(const std::string& name) { return name.starts_with("habits."); }

/// Whether a tensor is of a network that reads what another one knows (inbetween/foot_contact_net.h): it fits no other
/// weights of that one.
bool is_reader(const std::string& name) { return name.starts_with("feet."); }

SafeTensors without_readers(SafeTensors model) {
  std::erase_if(model.tensors, [](const auto& entry) { return is_reader(entry.first); });
  return model;
}

auto count_of_weights(const SafeTensors& model) {
  return std::count_if(model.tensors.begin(), model.tensors.end(),
                       [](const auto& entry) { return !is_recorded(entry.first); });
}

/// Whether the metadata that is no configuration is the same.
bool same_kind(const SafeTensors& a, const SafeTensors& b) {
  auto rest = a.metadata, other = b.metadata;
  return rest.erase("config") == other.erase("config") && rest == other;
}

}  // namespace

SafeTensors mean_of_models(const std::vector<std::string>& paths, const std::vector<double>& weights) {
  if (paths.empty()) throw Error("mean of models", "needs one or more");
  if (weights.size() != paths.size())
    throw Error("mean of models",
                std::to_string(weights.size()) + " weights for " + std::to_string(paths.size()) + " models");
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (const double weight : weights)
    if (!(weight >= 0) || !std::isfinite(sum) || sum <= 0)
      throw Error("mean of models", "weights must be numbers from 0 on, one of them above it");

  SafeTensors mean = without_readers(read_safetensors(paths[0]));
  std::map<std::string, Tensor> sums;
  for (size_t i = 0; i < paths.size(); ++i) {
    const SafeTensors model = i == 0 ? mean : without_readers(read_safetensors(paths[i]));
    if (!same_kind(model, mean) || !agree(sizes_of(model), sizes_of(mean)))
      throw Error(paths[i], "has another configuration than " + paths[0]);
    if (count_of_weights(model) != count_of_weights(mean)) throw Error(paths[i], "has other tensors than " + paths[0]);
    for (const auto& [name, first] : mean.tensors) {
      if (is_recorded(name)) continue;
      const auto found = model.tensors.find(name);
      if (found == model.tensors.end() || found->second.sizes() != first.sizes())
        throw Error(paths[i], name + " is missing or of another shape than in " + paths[0]);
      if (!first.is_floating_point()) {
        if (!torch::equal(found->second, first))
          throw Error(paths[i], name + " differs from " + paths[0] + " and has no mean");
        continue;
      }
      const Tensor weighted = found->second.to(torch::kFloat64) * (weights[i] / sum);
      if (!weighted.isfinite().all().item<bool>()) throw Error(paths[i], name + " is not finite");
      sums[name] = i == 0 ? weighted : sums[name] + weighted;
    }
  }
  for (const auto& [name, total] : sums) mean.tensors[name] = total.to(mean.tensors[name].scalar_type());
  return mean;
}

}  // namespace inhabit
