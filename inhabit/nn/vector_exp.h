#pragma once
#include <cstdint>
#include <cstring>

#include "inhabit/math/simd.h"

namespace inhabit::nn {

/// x becomes exp(x), clamped to +-87, good to some 2e-7: Cody and Waite's reduction to |r| <= ln(2)/2 and a Taylor
/// polynomial of degree 7. `Float` is a vector of kWidth floats; by reference, because vectors wider than the
/// baseline's are not passed alike everywhere. For kernels only.
template <int kWidth, class Float>
INHABIT_INLINE void vector_exp(Float& x) {
  typedef int32_t Int __attribute__((vector_size(kWidth * sizeof(float))));
  x = x > 87.0F ? (x - x + 87.0F) : x;
  x = x < -87.0F ? (x - x - 87.0F) : x;
  const Float shifted = x * 1.44269504F + 12582912.0F;  // 1.5 * 2^23: the low bits are now the rounded quotient
  const Float n = shifted - 12582912.0F;
  const Float r = (x - n * 0.693359375F) + n * 2.12194440e-4F;
  Float p = r * (1.0F / 5040) + (1.0F / 720);
  p = p * r + (1.0F / 120);
  p = p * r + (1.0F / 24);
  p = p * r + (1.0F / 6);
  p = p * r + 0.5F;
  p = p * r + 1.0F;
  p = p * r + 1.0F;
  Int bits;
  std::memcpy(&bits, &shifted, sizeof(bits));
  bits = (bits - 0x4B400000 + 127) << 23;  // 2^n
  Float scale;
  std::memcpy(&scale, &bits, sizeof(scale));
  x = p * scale;
}

/// x becomes 1 / (1 + exp(-x)), good to some 2e-7. For kernels only.
template <int kWidth, class Float>
INHABIT_INLINE void vector_sigmoid(Float& x) {
  x = -x;
  vector_exp<kWidth>(x);
  x = 1.0F / (1.0F + x);
}

/// x becomes tanh(x) = 2 sigmoid(2 x) - 1, good to some 4e-7, which near 0 is much of it. For kernels only.
template <int kWidth, class Float>
INHABIT_INLINE void vector_tanh(Float& x) {
  x = 2.0F * x;
  vector_sigmoid<kWidth>(x);
  x = 2.0F * x - 1.0F;
}

/// What mish(x) = x tanh(log(1 + exp(x))) multiplies x with, from e = exp(min(x, 20)): tanh(log(1 + e)) is n / (n + 2)
/// for n = e (e + 2), and 1 in float from 20 on. For vectors of kWidth and, of 1, single numbers; good to some 4e-7.
/// For kernels only.
template <int kWidth, class Float>
INHABIT_INLINE void mish_factor(Float& e) {
  const Float n = e * (e + 2.0F);
  e = n / (n + 2.0F);
}

}  // namespace inhabit::nn
