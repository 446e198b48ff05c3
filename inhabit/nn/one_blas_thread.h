#pragma once
#include <mutex>

extern "C" {
// OpenBLAS, where it is the BLAS that LibTorch uses.
__attribute__((weak)) void openblas_set_num_threads(int threads);
__attribute__((weak)) int openblas_get_num_threads(void);
}

namespace inhabit::nn {

/// While any lives OpenBLAS spreads no product over threads of its own: for work that is spread over threads itself,
/// whose small products wait for OpenBLAS's threads for a third of the time otherwise.
class OneBlasThread {
 public:
  OneBlasThread() {
    if (openblas_set_num_threads == nullptr || openblas_get_num_threads == nullptr) return;
    const std::lock_guard<std::mutex> lock(mutex_);
    if (living_++ > 0) return;
    before_ = openblas_get_num_threads();
    openblas_set_num_threads(1);
  }
  ~OneBlasThread() {
    if (openblas_set_num_threads == nullptr || openblas_get_num_threads == nullptr) return;
    const std::lock_guard<std::mutex> lock(mutex_);
    if (--living_ == 0) openblas_set_num_threads(before_);
  }
  OneBlasThread(const OneBlasThread&) = delete;
  OneBlasThread& operator=(const OneBlasThread&) = delete;

 private:
  inline static std::mutex mutex_;
  inline static int living_ = 0, before_ = 1;  // of all threads
};

}  // namespace inhabit::nn
