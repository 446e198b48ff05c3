#include "inhabit/train/checkpoint.h"

#include <cmath>
#include <sstream>

#include "inhabit/error.h"
#include "inhabit/io/number_text.h"
#include "inhabit/io/safetensors.h"

namespace inhabit {
namespace {

// LibTorch 1.13 keys the optimizer's state by a string made of the tensor's address, 2.x by the address itself.
template <class Key>
Key state_key(const torch::Tensor& parameter) {
  if constexpr (std::is_same_v<Key, std::string>) {
    std::ostringstream text;  // as c10::guts::to_string writes it
    text << parameter.unsafeGetTensorImpl();
    return text.str();
  } else
    return parameter.unsafeGetTensorImpl();
}

using StateMap = std::decay_t<decltype(std::declval<torch::optim::AdamW&>().state())>;

}  // namespace

void save_checkpoint(const std::string& path, const torch::nn::Module& module, torch::optim::AdamW& optimizer,
                     const std::map<std::string, torch::Tensor>& average,
                     const std::map<std::string, std::string>& state) {
  SafeTensors file;
  file.metadata = state;
  for (const auto& p : module.named_parameters()) {
    file.tensors["module." + p.key()] = p.value().detach().cpu();
    const auto found = optimizer.state().find(state_key<StateMap::key_type>(p.value()));
    if (found == optimizer.state().end()) continue;
    const auto& adam = static_cast<const torch::optim::AdamWParamState&>(*found->second);
    file.tensors["adam.mean." + p.key()] = adam.exp_avg().cpu();
    file.tensors["adam.variance." + p.key()] = adam.exp_avg_sq().cpu();
    file.tensors["adam.step." + p.key()] = torch::tensor({adam.step()}, torch::kInt64);
  }
  for (const auto& b : module.named_buffers()) file.tensors["module." + b.key()] = b.value().detach().cpu();
  for (const auto& [name, weight] : average) file.tensors["average." + name] = weight.cpu();
  write_safetensors(path, file);
}

std::map<std::string, std::string> load_checkpoint(const std::string& path, torch::nn::Module& module,
                                                   torch::optim::AdamW& optimizer,
                                                   std::map<std::string, torch::Tensor>& average) {
  torch::NoGradGuard no_grad;
  SafeTensors file = read_safetensors(path);
  auto take = [&](const std::string& name, torch::Tensor into) {
    const auto found = file.tensors.find(name);
    if (found == file.tensors.end() || found->second.sizes() != into.sizes())
      throw Error(path, "is not a checkpoint of this network (" + name + " is missing or of another size)");
    into.copy_(found->second);
  };
  for (const auto& p : module.named_parameters()) {
    take("module." + p.key(), p.value());
    if (file.tensors.count("adam.mean." + p.key()) == 0) continue;
    auto adam = std::make_unique<torch::optim::AdamWParamState>();
    adam->exp_avg(torch::zeros_like(p.value()));
    adam->exp_avg_sq(torch::zeros_like(p.value()));
    take("adam.mean." + p.key(), adam->exp_avg());
    take("adam.variance." + p.key(), adam->exp_avg_sq());
    torch::Tensor step = torch::zeros({1}, torch::kInt64);
    take("adam.step." + p.key(), step);
    adam->step(step.item<int64_t>());
    optimizer.state()[state_key<StateMap::key_type>(p.value())] = std::move(adam);
  }
  for (const auto& b : module.named_buffers()) take("module." + b.key(), b.value());
  for (auto& [name, weight] : average) take("average." + name, weight);
  return file.metadata;
}

double checkpoint_number(const std::map<std::string, std::string>& state, const std::string& key,
                         const std::string& path) {
  const auto found = state.find(key);
  double number = 0;
  if (found == state.end() || !parse_number(found->second, number) || std::isnan(number))
    throw Error(path, "is not a checkpoint (" + key + " is missing or no number)");
  return number;
}

}  // namespace inhabit
