#pragma once
#include <thread>
#include <vector>

namespace inhabit {

/// What `run` gives on each of `count` threads at once.
template <class Run>
auto at_once(size_t count, const Run& run) {
  std::vector<decltype(run())> out(count);
  std::vector<std::thread> threads;
  for (auto& result : out) threads.emplace_back([&] { result = run(); });
  for (std::thread& thread : threads) thread.join();
  return out;
}

}  // namespace inhabit
