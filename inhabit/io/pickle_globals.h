#pragma once
#include <map>
#include <string>
#include <vector>

#include "inhabit/io/pickle.h"

namespace inhabit {

// What pickles may call, for pickle.cpp alone.

/// The numbers of the tensors in a file of torch.save, which come after its pickle.
struct TorchStorages {
  std::map<std::string, torch::Tensor> by_key;  ///< one dimension; filled when the pickle has been read
  uint64_t most_bytes = 0;                      ///< that all of them can have: the file's
  uint64_t bytes = 0;                           ///< that they have
};

/// Such numbers by what a pickle says of them: ("storage", type, key, device, how many[, no view]). Throws
/// Error(subject, ...) where it says something else, or more than the file can hold.
torch::Tensor torch_storage(const PickleValue& told, TorchStorages& storages, const std::string& subject);

/// The one name in this project for a global that a pickle may use ("reconstruct"), empty where it is not allowed.
std::string allowed_global(const std::string& module, const std::string& name);

/// What such a global gives for its arguments (a tuple). Throws Error(subject, ...) where they are not its own.
PickleValue call_global(const std::string& global, const PickleValue& arguments, const std::string& subject);

/// Gives an array or a dtype its state (BUILD). Throws Error(subject, ...) where either is something else.
void set_state(PickleValue& object, const PickleValue& state, const std::string& subject);

}  // namespace inhabit
