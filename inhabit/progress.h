#pragma once
#include <cstdint>
#include <functional>

namespace inhabit {

/// Called with how many items are done and how many there are in all, from one thread at a time.
using Progress = std::function<void(int64_t done, int64_t all)>;

/// How far one of `count` jobs of the same length is, told as how far all of them are, one after the other; empty where
/// `whole` is. @param number of the job, from 0
inline Progress part_of(const Progress& whole, int64_t number, int64_t count) {
  if (!whole) return {};
  return [=](int64_t done, int64_t all) { whole(number * all + done, count * all); };
}

}  // namespace inhabit
