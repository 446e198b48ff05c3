#pragma once
#include <ATen/Parallel.h>
#include <sched.h>

#include <atomic>
#include <cstdint>
#include <memory>

namespace inhabit::interact {

/// Stages of work that follow each other, each of so many pieces that may be done in any order.
struct WorkStages {
  static constexpr int kMost = 24;

  struct Counters {
    std::atomic<int64_t> taken[kMost] = {}, done[kMost] = {};
  };
  int stages = 0;
  int64_t pieces[kMost] = {};
  std::unique_ptr<Counters> counters = std::make_unique<Counters>();

  void add(int64_t count) { pieces[stages++] = count; }

  /// Calls work(stage, piece) for all. Several threads take pieces as they come; a stage begins when the one before is
  /// done, whoever did it: a thread that starts late, as they do when waiting is passive, holds nobody up. Nothing is
  /// allocated. Not to be called on one object from two threads at once. @param work must not throw.
  template <class Work>
  void run(int threads, const Work& work) {
    if (threads <= 1) {
      for (int s = 0; s < stages; ++s)
        for (int64_t i = 0; i < pieces[s]; ++i) work(s, i);
      return;
    }
    auto& taken = counters->taken;
    auto& done = counters->done;
    for (int s = 0; s < stages; ++s) {
      taken[s].store(0, std::memory_order_relaxed);
      done[s].store(0, std::memory_order_relaxed);
    }
#pragma omp parallel num_threads(threads)
    {
      for (int s = 0; s < stages; ++s) {
        for (int64_t i = taken[s].fetch_add(1); i < pieces[s]; i = taken[s].fetch_add(1)) {
          work(s, i);
          done[s].fetch_add(1, std::memory_order_release);
        }
        for (int spins = 0; done[s].load(std::memory_order_acquire) < pieces[s]; ++spins)
          if (spins > 4000) sched_yield();
      }
    }
  }
};

/// How many threads so many multiplications are worth: none but this one where others are at work already.
inline int threads_for(int64_t multiplications) {
  if (multiplications < 2'000'000 || at::in_parallel_region()) return 1;
  return at::get_num_threads();
}

}  // namespace inhabit::interact
