#include "inhabit/nn/model_file.h"

#include "inhabit/error.h"

namespace inhabit::nn {

std::string ModelFile::system() const {
  const auto found = content.metadata.find("system");
  return found == content.metadata.end() ? "" : found->second;
}

const std::string& ModelFile::config_of(const std::string& wanted) const {
  if (const std::string named = system(); named != wanted)
    throw Error(path, "is not a model of " + wanted + (named.empty() ? "" : " but of '" + named.substr(0, 60) + "'"));
  const auto config = content.metadata.find("config");
  if (config == content.metadata.end()) throw Error(path, "metadata lacks the configuration");
  return config->second;
}

torch::Tensor ModelFile::tensor(const std::string& name, const std::vector<int64_t>& shape) const {
  const auto found = content.tensors.find(name);
  if (found == content.tensors.end()) throw Error(path, "lacks " + name);
  const torch::Tensor t = found->second.to(torch::kFloat32);
  bool fits = t.dim() == static_cast<int64_t>(shape.size());
  for (size_t i = 0; fits && i < shape.size(); ++i)
    fits = shape[i] < 0 ? t.size(static_cast<int64_t>(i)) > 0 : t.size(static_cast<int64_t>(i)) == shape[i];
  if (!fits) throw Error(path, name + " has the wrong shape");
  if (!t.isfinite().all().item<bool>()) throw Error(path, name + " is not finite");
  return t;
}

torch::Tensor ModelFile::positive_tensor(const std::string& name, const std::vector<int64_t>& shape) const {
  torch::Tensor t = tensor(name, shape);
  if ((t <= 0).any().item<bool>()) throw Error(path, name + " is not positive");
  return t;
}

ModelFile read_model_file(const std::string& path) { return {path, read_safetensors(path)}; }

SafeTensors model_content(const std::string& system, const std::string& config) {
  SafeTensors content;
  content.metadata = {{"system", system}, {"config", config}};
  return content;
}

}  // namespace inhabit::nn
