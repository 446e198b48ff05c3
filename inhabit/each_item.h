#pragma once
#include <omp.h>

#include <cstdint>
#include <exception>

#include "inhabit/interruption.h"
#include "inhabit/progress.h"

namespace inhabit {

/// work(i) for every i in [0, count) on OpenMP's threads, whoever is free taking the next. @param progress called with
/// the number done and `count`, from one thread at a time; may be empty. What the first of them throws is thrown here,
/// and what has not begun by then is left out.
/// @param threads at most; 0: as many as OpenMP has
template <class Work>
void each_item(int64_t count, const Progress& progress, const Work& work, int threads = 0) {
  const int team = threads > 0 ? threads : omp_get_max_threads();
  std::exception_ptr failed;
  int64_t done = 0;
#pragma omp parallel for schedule(dynamic) num_threads(team)
  for (int64_t i = 0; i < count; ++i) {
    bool left_out = false;
#pragma omp critical(inhabit_each_item)
    left_out = failed != nullptr;
    if (left_out) continue;
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
    }
  }
  if (failed) std::rethrow_exception(failed);
}

}  // namespace inhabit
