#pragma once
#include <ATen/autocast_mode.h>

namespace inhabit {

/// While one lives and `on`, LibTorch multiplies matrices and convolves on this thread in bfloat16 (8 bits of
/// mantissa, sums in float32): three to four times faster on CPUs with tiles for it (AMX). Weights stay float32; their
/// gradients come out of such products and are kept in float32. For the forward pass of a network alone, never for
/// positions that come out: 2 m would be off by 4 mm.
class Bfloat16Products {
 public:
  explicit Bfloat16Products(bool on) : before_(at::autocast::is_cpu_enabled()) { at::autocast::set_cpu_enabled(on); }
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
