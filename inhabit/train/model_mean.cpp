#include "inhabit/train/model_mean.h"

#include <cmath>
#include <numeric>

#include "inhabit/error.h"

namespace inhabit {

using torch::Tensor;

SafeTensors mean_of_models(const std::vector<std::string>& paths, const std::vector<double>& weights) {
  if (paths.empty()) throw Error("mean of models", "needs one or more");
  if (weights.size() != paths.size())
    throw Error("mean of models",
                std::to_string(weights.size()) + " weights for " + std::to_string(paths.size()) + " models");
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (const double weight : weights)
    if (!(weight >= 0) || !std::isfinite(sum) || sum <= 0)
      throw Error("mean of models", "weights must be numbers from 0 on, one of them above it");

  SafeTensors mean = read_safetensors(paths[0]);
  std::map<std::string, Tensor> sums;
  for (size_t i = 0; i < paths.size(); ++i) {
    const SafeTensors model = i == 0 ? mean : read_safetensors(paths[i]);
    if (model.metadata != mean.metadata) throw Error(paths[i], "has another configuration than " + paths[0]);
    if (model.tensors.size() != mean.tensors.size()) throw Error(paths[i], "has other tensors than " + paths[0]);
    for (const auto& [name, first] : mean.tensors) {
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
