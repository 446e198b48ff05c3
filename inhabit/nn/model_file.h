#pragma once
#include <string>
#include <vector>

#include "inhabit/io/safetensors.h"
#include "inhabit/nn/parameters.h"

namespace inhabit::nn {

/// A model file as all systems have it: the system's name and its configuration (JSON) in the metadata, the parameters
/// of each network under a prefix of its own, and what else belongs to the model, as the scale of its features.
struct ModelFile {
  std::string path;     ///< in errors
  SafeTensors content;  ///< all of it

  /// The system it says it is of; empty for files with released weights, which say none.
  std::string system() const;
  /// Throws Error unless it says that it is of `system` and holds a configuration, which is returned.
  const std::string& config_of(const std::string& system) const;
  /// A float32 tensor of `shape`, in which -1 stands for any size over 0. Throws Error where it is missing, of another
  /// shape or not finite.
  torch::Tensor tensor(const std::string& name, const std::vector<int64_t>& shape) const;
  /// The same, where every number must be over 0.
  torch::Tensor positive_tensor(const std::string& name, const std::vector<int64_t>& shape) const;

  /// The network whose parameters stand under `prefix`, in evaluation mode on the CPU: `make` makes it, of the file's
  /// sizes. Null where the file has none. Throws Error where a parameter is missing, of another shape or not finite.
  template <class Make>
  auto network(const std::string& prefix, const Make& make) const -> decltype(make()) {
    if (!has_parameters(content, prefix)) return nullptr;
    auto network = make();
    load_parameters(*network, prefix, content, path);
    return network;
  }
};

/// Throws Error naming the file where it is no safetensors file.
ModelFile read_model_file(const std::string& path);

/// A file's content so far: system and configuration.
SafeTensors model_content(const std::string& system, const std::string& config);

}  // namespace inhabit::nn
