#pragma once
#include <ATen/Parallel.h>

#include <atomic>
#include <cstdint>
#include <exception>

#include "inhabit/interruption.h"

namespace inhabit::nn {

/// Calls work(chunk) for every chunk in [0, count) on LibTorch's number of threads, whoever is free taking the next.
/// What the first of them throws is thrown here: chunks that have not begun by then are left out, and others end at
/// their next interruption point.
template <class Work>
void parallel_chunks(int64_t count, const Work& work) {
  if (count <= 1 || at::get_num_threads() == 1 || at::in_parallel_region()) {
    for (int64_t chunk = 0; chunk < count; ++chunk) work(chunk);
    return;
  }
  std::exception_ptr thrown;  // may not leave the parallel region by itself
  std::atomic<bool> over = false;
#pragma omp parallel num_threads(at::get_num_threads())
  {
    const Interruptible others(ends_once(over));
#pragma omp for schedule(dynamic, 1)
    for (int64_t chunk = 0; chunk < count; ++chunk) {
      if (over.load(std::memory_order_relaxed)) continue;
      try {
        work(chunk);
      } catch (...) {
#pragma omp critical(inhabit_parallel_chunks)
        if (!thrown) thrown = std::current_exception();
        over = true;
      }
    }
  }
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace inhabit::nn
