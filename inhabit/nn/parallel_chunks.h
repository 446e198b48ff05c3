#pragma once
#include <ATen/Parallel.h>

#include <cstdint>
#include <exception>

namespace inhabit::nn {

/// Calls work(chunk) for every chunk in [0, count) on LibTorch's number of threads, whoever is free taking the next.
/// What a chunk throws is thrown here once all are done: the first of several.
template <class Work>
void parallel_chunks(int64_t count, const Work& work) {
  if (count <= 1 || at::get_num_threads() == 1 || at::in_parallel_region()) {
    for (int64_t chunk = 0; chunk < count; ++chunk) work(chunk);
    return;
  }
  std::exception_ptr thrown;  // may not leave the parallel region by itself
#pragma omp parallel for schedule(dynamic, 1) num_threads(at::get_num_threads())
  for (int64_t chunk = 0; chunk < count; ++chunk) {
    try {
      work(chunk);
    } catch (...) {
#pragma omp critical(inhabit_parallel_chunks)
      if (!thrown) thrown = std::current_exception();
    }
  }
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace inhabit::nn
