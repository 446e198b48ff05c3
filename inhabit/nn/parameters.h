#pragma once
#include <torch/torch.h>

#include <string>

#include "inhabit/io/safetensors.h"

namespace inhabit::nn {

/// Adds a module's parameters and buffers to `content` as `prefix` + name. Batch norm's step counters are left out:
/// nothing reads them.
void collect_parameters(const torch::nn::Module& module, const std::string& prefix, SafeTensors& content);

/// True where `content` holds a tensor whose name starts with `prefix`.
bool has_parameters(const SafeTensors& content, const std::string& prefix);

/// Copies `prefix` + name from `content` into every parameter and buffer, in their own element type, and puts the
/// module in evaluation mode. Throws Error(file, ...) where one is missing, of another shape or not finite.
void load_parameters(torch::nn::Module& module, const std::string& prefix, const SafeTensors& content,
                     const std::string& file);

}  // namespace inhabit::nn
