#pragma once
#include <cstdint>
#include <functional>
#include <string>

namespace inhabit {

/// A row of an evaluation: a name, and what makes an output of an input. `random` is false where the seed changes
/// nothing.
template <class Input, class Output>
struct Method {
  std::string name;                                              ///< of its row
  std::function<Output(const Input& input, uint64_t seed)> run;  ///< the same output for the same input and seed
  bool random = false;                                           ///< runs with several seeds are worth making
};

}  // namespace inhabit
