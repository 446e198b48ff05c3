#pragma once
#include <cstdint>
#include <functional>

namespace inhabit {

/// Called with how many items are done and how many there are in all, from one thread at a time.
using Progress = std::function<void(int64_t done, int64_t all)>;

}  // namespace inhabit
