#pragma once
#include <ATen/autocast_mode.h>

#if defined(__x86_64__)
#include <cpuid.h>
#endif

namespace inhabit {

/// Whether the processor has tiles for products in bfloat16 (AMX). Without them LibTorch 1.13's are twenty to thirty
/// times slower than in float32 (a convolution and a linear layer, forward and backward, on an EPYC 7003).
inline bool has_bfloat16_tiles() {
#if defined(__x86_64__)
  unsigned a = 0, b = 0, c = 0, d = 0;
  return __get_cpuid_count(7, 0, &a, &b, &c, &d) != 0 && (d & (1U << 22)) != 0;
#else
  return false;
#endif
}

/// While one lives and `on`, where the processor has tiles for it, LibTorch multiplies matrices and convolves on this
/// thread in bfloat16 (8 bits of mantissa, sums in float32): three to four times faster. Weights stay float32; their
/// gradients come out of such products and are kept in float32. For the forward pass of a network alone, never for
/// positions that come out: 2 m would be off by 4 mm.
class Bfloat16Products {
 public:
  /// @param on false: products stay in float32
  explicit Bfloat16Products(bool on) : before_(at::autocast::is_cpu_enabled()) {
    at::autocast::set_cpu_enabled(on && has_bfloat16_tiles());
  }
  ~Bfloat16Products() {
    at::autocast::clear_cache();  // of weights as they were before the next step
    at::autocast::set_cpu_enabled(before_);
  }
  Bfloat16Products(const Bfloat16Products&) = delete;
  Bfloat16Products& operator=(const Bfloat16Products&) = delete;

 private:
  bool before_;
};

}  // namespace inhabit
