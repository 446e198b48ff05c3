#include "inhabit/nn/norm_kernel.h"

#include <cmath>
#include <cstring>

#include "inhabit/math/simd.h"
#include "inhabit/nn/vector_exp.h"

namespace inhabit::nn {
namespace {

template <int kWidth>
INHABIT_INLINE void sums_of(const float* x, int64_t stride, int64_t rows, int64_t columns, float centre, bool squared,
                            float* sums) {
  typedef float Float __attribute__((vector_size(kWidth * sizeof(float))));
  int64_t c = 0;
  for (; c + kWidth <= columns; c += kWidth) {
    Float sum = {};
    for (int64_t r = 0; r < rows; ++r) {
      Float v;
      std::memcpy(&v, x + r * stride + c, sizeof(v));
      if (squared) {
        v -= centre;
        v *= v;
      }
      sum += v;
    }
    std::memcpy(sums + c, &sum, sizeof(sum));
  }
  for (; c < columns; ++c) {
    sums[c] = 0;
    for (int64_t r = 0; r < rows; ++r) {
      const float v = x[r * stride + c];
      sums[c] += squared ? (v - centre) * (v - centre) : v;
    }
  }
}

template <int kWidth>
INHABIT_INLINE void mish_of(const float* x, int64_t x_stride, int64_t rows, int64_t columns, const float* scale,
                            const float* shift, const float* add, int64_t add_stride, float* y, int64_t y_stride) {
  typedef float Float __attribute__((vector_size(kWidth * sizeof(float))));
  for (int64_t r = 0; r < rows; ++r) {
    const float* from = x + r * x_stride;
    const float* beside = add == nullptr ? nullptr : add + r * add_stride;
    float* to = y + r * y_stride;
    int64_t c = 0;
    for (; c + kWidth <= columns; c += kWidth) {
      Float v, a, b;
      std::memcpy(&v, from + c, sizeof(v));
      std::memcpy(&a, scale + c, sizeof(a));
      std::memcpy(&b, shift + c, sizeof(b));
      v = v * a + b;
      Float e = v > 20.0F ? (v - v + 20.0F) : v;
      vector_exp<kWidth>(e);
      mish_factor<kWidth>(e);
      v *= e;
      if (beside != nullptr) {
        std::memcpy(&a, beside + c, sizeof(a));
        v += a;
      }
      std::memcpy(to + c, &v, sizeof(v));
    }
    for (; c < columns; ++c) {
      const float v = from[c] * scale[c] + shift[c];
      float t = std::exp(v > 20.0F ? 20.0F : v);
      mish_factor<1>(t);
      to[c] = v * t + (beside == nullptr ? 0.0F : beside[c]);
    }
  }
}

INHABIT_TARGET_AVX512 void sums_avx512(const float* x, int64_t stride, int64_t rows, int64_t columns, float centre,
                                       bool squared, float* sums) {
  sums_of<16>(x, stride, rows, columns, centre, squared, sums);
}
INHABIT_TARGET_AVX2 void sums_avx2(const float* x, int64_t stride, int64_t rows, int64_t columns, float centre,
                                   bool squared, float* sums) {
  sums_of<8>(x, stride, rows, columns, centre, squared, sums);
}
INHABIT_TARGET_AVX512 void mish_avx512(const float* x, int64_t x_stride, int64_t rows, int64_t columns,
                                       const float* scale, const float* shift, const float* add, int64_t add_stride,
                                       float* y, int64_t y_stride) {
  mish_of<16>(x, x_stride, rows, columns, scale, shift, add, add_stride, y, y_stride);
}
INHABIT_TARGET_AVX2 void mish_avx2(const float* x, int64_t x_stride, int64_t rows, int64_t columns, const float* scale,
                                   const float* shift, const float* add, int64_t add_stride, float* y,
                                   int64_t y_stride) {
  mish_of<8>(x, x_stride, rows, columns, scale, shift, add, add_stride, y, y_stride);
}

}  // namespace

void column_sums(const float* x, int64_t stride, int64_t rows, int64_t columns, float centre, bool squared,
                 float* sums) {
  for_simd_level(sums_avx512, sums_avx2, sums_of<4>)(x, stride, rows, columns, centre, squared, sums);
}

void scaled_mish(const float* x, int64_t x_stride, int64_t rows, int64_t columns, const float* scale,
                 const float* shift, const float* add, int64_t add_stride, float* y, int64_t y_stride) {
  for_simd_level(mish_avx512, mish_avx2, mish_of<4>)(x, x_stride, rows, columns, scale, shift, add, add_stride, y,
                                                     y_stride);
}

}  // namespace inhabit::nn
