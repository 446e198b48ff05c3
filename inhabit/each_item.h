#pragma once
#include <omp.h>

#include <atomic>
#include <cstdint>
#include <exception>

#include "inhabit/interruption.h"
#include "inhabit/progress.h"

namespace inhabit {

/// work(i) for every i in [0, count) on OpenMP's threads, whoever is free taking the next. @param progress called with
/// the number done and `count`, from one thread at a time; may be empty. What the first of them throws is thrown here,
/// and what has not begun by then is left out; the rest ends at its next interruption point.
/// @param threads at most; 0: as many as OpenMP has
template <class Work>
void each_item(int64_t count, const Progress& progress, const Work& work, int threads = 0) {
  const int team = threads > 0 ? threads : omp_get_max_threads();
  std::exception_ptr failed;
  int64_t done = 0;
  std::atomic<bool> over = false;
#pragma omp parallel num_threads(team)
  {
    const Interruptible others(ends_once(over));
#pragma omp for schedule(dynamic)
    for (int64_t i = 0; i < count; ++i) {
      if (over.load(std::memory_order_relaxed)) continue;
      std::exception_ptr thrown;
      try {
        interruption_point();
        work(i);
      } catch (...) {
        thrown = std::current_exception();
      }
#pragma omp critical(inhabit_each_item)
      {
        try {
          if (!thrown && !failed && progress) progress(++done, count);
        } catch (...) {
          thrown = std::current_exception();
        }
        if (thrown && !failed) failed = thrown;
        if (failed) over = true;
      }
    }
  }
  if (failed) std::rethrow_exception(failed);
}

}  // namespace inhabit
