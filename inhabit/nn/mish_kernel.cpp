#include "inhabit/nn/mish_kernel.h"

#include <cmath>
#include <cstring>

#include "inhabit/math/simd.h"
#include "inhabit/nn/vector_exp.h"

namespace inhabit::nn {
namespace {

// With e = exp(x) and t = tanh(log(1 + e)), mish' = t + x (1 - t^2) e / (1 + e).

template <int kWidth>
INHABIT_INLINE void forward(const float* x, int64_t count, float* y) {
  typedef float Float __attribute__((vector_size(kWidth * sizeof(float))));
  int64_t i = 0;
  for (; i + kWidth <= count; i += kWidth) {
    Float v;
    std::memcpy(&v, x + i, sizeof(v));
    Float e = v > 20.0F ? (v - v + 20.0F) : v;
    vector_exp<kWidth>(e);
    mish_factor<kWidth>(e);
    v *= e;
    std::memcpy(y + i, &v, sizeof(v));
  }
  for (; i < count; ++i) {
    float t = std::exp(x[i] > 20.0F ? 20.0F : x[i]);
    mish_factor<1>(t);
    y[i] = x[i] * t;
  }
}

template <int kWidth>
INHABIT_INLINE void backward(const float* x, const float* gradient, int64_t count, float* out) {
  typedef float Float __attribute__((vector_size(kWidth * sizeof(float))));
  int64_t i = 0;
  for (; i + kWidth <= count; i += kWidth) {
    Float v, g;
    std::memcpy(&v, x + i, sizeof(v));
    std::memcpy(&g, gradient + i, sizeof(g));
    Float e = v > 20.0F ? (v - v + 20.0F) : v;
    vector_exp<kWidth>(e);
    Float t = e;
    mish_factor<kWidth>(t);
    g *= t + v * (1.0F - t * t) * (e / (1.0F + e));
    std::memcpy(out + i, &g, sizeof(g));
  }
  for (; i < count; ++i) {
    const float e = std::exp(x[i] > 20.0F ? 20.0F : x[i]);
    float t = e;
    mish_factor<1>(t);
    out[i] = gradient[i] * (t + x[i] * (1.0F - t * t) * (e / (1.0F + e)));
  }
}

INHABIT_TARGET_AVX512 void forward_avx512(const float* x, int64_t count, float* y) { forward<16>(x, count, y); }
INHABIT_TARGET_AVX2 void forward_avx2(const float* x, int64_t count, float* y) { forward<8>(x, count, y); }
INHABIT_TARGET_AVX512 void backward_avx512(const float* x, const float* gradient, int64_t count, float* out) {
  backward<16>(x, gradient, count, out);
}
INHABIT_TARGET_AVX2 void backward_avx2(const float* x, const float* gradient, int64_t count, float* out) {
  backward<8>(x, gradient, count, out);
}

}  // namespace

void mish_forward(const float* x, int64_t count, float* y) {
  for_simd_level(forward_avx512, forward_avx2, forward<4>)(x, count, y);
}

void mish_backward(const float* x, const float* gradient, int64_t count, float* out) {
  for_simd_level(backward_avx512, backward_avx2, backward<4>)(x, gradient, count, out);
}

}  // namespace inhabit::nn
