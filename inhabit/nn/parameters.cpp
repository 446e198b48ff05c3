#include "inhabit/nn/parameters.h"

#include <sstream>

#include "inhabit/error.h"

namespace inhabit::nn {
namespace {

bool is_counter(const std::string& name) {
  static const std::string suffix = "num_batches_tracked";
  return name.size() >= suffix.size() && name.compare(name.size() - suffix.size(), suffix.size(), suffix) == 0;
}

std::string shape_text(const torch::Tensor& tensor) {
  std::ostringstream text;
  text << tensor.sizes();
  return text.str();
}

}  // namespace

void collect_parameters(const torch::nn::Module& module, const std::string& prefix, SafeTensors& content) {
  for (const auto& item : module.named_parameters()) content.tensors[prefix + item.key()] = item.value().detach();
  for (const auto& item : module.named_buffers()) {
    if (!is_counter(item.key())) content.tensors[prefix + item.key()] = item.value().detach();
  }
}

bool has_parameters(const SafeTensors& content, const std::string& prefix) {
  const auto found = content.tensors.lower_bound(prefix);
  return found != content.tensors.end() && found->first.compare(0, prefix.size(), prefix) == 0;
}

void load_parameters(torch::nn::Module& module, const std::string& prefix, const SafeTensors& content,
                     const std::string& file) {
  torch::NoGradGuard no_gradients;
  const auto load = [&](const std::string& name, torch::Tensor into) {
    const auto found = content.tensors.find(prefix + name);
    if (found == content.tensors.end()) throw Error(file, "lacks the parameter '" + prefix + name + "'");
    const torch::Tensor& from = found->second;
    if (from.sizes() != into.sizes())
      throw Error(file, "parameter '" + prefix + name + "' is " + shape_text(from) + ", not " + shape_text(into));
    into.copy_(from);
    if (!torch::isfinite(into).all().item<bool>()) throw Error(file, "parameter '" + prefix + name + "' is not finite");
  };
  for (const auto& item : module.named_parameters()) load(item.key(), item.value());
  for (const auto& item : module.named_buffers()) {
    if (!is_counter(item.key())) load(item.key(), item.value());
  }
  module.eval();
}

}  // namespace inhabit::nn
