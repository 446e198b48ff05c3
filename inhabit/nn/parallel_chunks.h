#pragma once
#include <ATen/Parallel.h>

#include <cstdint>

namespace inhabit::nn {

/// Calls work(chunk) for every chunk in [0, count) on LibTorch's number of threads, whoever is free taking the next.
template <class Work>
void parallel_chunks(int64_t count, const Work& work) {
  if (count <= 1 || at::get_num_threads() == 1 || at::in_parallel_region()) {
    for (int64_t chunk = 0; chunk < count; ++chunk) work(chunk);
    return;
  }
#pragma omp parallel for schedule(dynamic, 1) num_threads(at::get_num_threads())
  for (int64_t chunk = 0; chunk < count; ++chunk) work(chunk);
}

}  // namespace inhabit::nn
