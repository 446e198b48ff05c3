#pragma once
#include <torch/torch.h>

#include <map>
#include <string>

namespace inhabit {

/// Everything a run needs to go on: weights and buffers as "module.*", their moving average, where there is one, as
/// "average.*", Adam's moments as "adam.*", numbers in `state`.
void save_checkpoint(const std::string& path, const torch::nn::Module& module, torch::optim::AdamW& optimizer,
                     const std::map<std::string, torch::Tensor>& average,
                     const std::map<std::string, std::string>& state);

/// Fills module, optimizer and `average`, returns `state`. Throws Error naming the file when it is not a checkpoint of
/// this module.
std::map<std::string, std::string> load_checkpoint(const std::string& path, torch::nn::Module& module,
                                                   torch::optim::AdamW& optimizer,
                                                   std::map<std::string, torch::Tensor>& average);

/// A number of a checkpoint's state. Throws Error(path, ...) where it is missing or no number.
double checkpoint_number(const std::map<std::string, std::string>& state, const std::string& key,
                         const std::string& path);

}  // namespace inhabit
