#include "progress.h"

#include <spdlog/spdlog.h>

#include <chrono>

std::function<void(int64_t, int64_t)> progress_lines(const std::string& what) {
  using Clock = std::chrono::steady_clock;
  return [what, last = Clock::now()](int64_t done, int64_t all) mutable {
    if (Clock::now() - last < std::chrono::seconds(10)) return;
    last = Clock::now();
    spdlog::info("{}: {} of {}", what, done, all);
  };
}
