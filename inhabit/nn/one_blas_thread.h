#pragma once

extern "C" {
// OpenBLAS, where it is the BLAS that LibTorch uses.
__attribute__((weak)) void openblas_set_num_threads(int threads);
__attribute__((weak)) int openblas_get_num_threads(void);
}

namespace inhabit::nn {

/// While it lives OpenBLAS spreads no product over threads of its own: for work that is spread over threads itself,
/// whose small products wait for OpenBLAS's threads for a third of the time otherwise.
class OneBlasThread {
 public:
  OneBlasThread() {
    if (openblas_set_num_threads == nullptr || openblas_get_num_threads == nullptr) return;
    threads_ = openblas_get_num_threads();
    openblas_set_num_threads(1);
  }
  ~OneBlasThread() {
    if (threads_ > 0) openblas_set_num_threads(threads_);
  }
  OneBlasThread(const OneBlasThread&) = delete;
  OneBlasThread& operator=(const OneBlasThread&) = delete;

 private:
  int threads_ = 0;
};

}  // namespace inhabit::nn
