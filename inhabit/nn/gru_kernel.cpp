#include "inhabit/nn/gru_kernel.h"

#include <cmath>
#include <cstring>

#include "inhabit/math/simd.h"

namespace inhabit::nn {
namespace {

/// x becomes 1 / (1 + exp(-x)): exp by Cody and Waite's reduction to |r| <= ln(2)/2 and a Taylor polynomial of
/// degree 7. By reference, because vectors wider than the baseline's are not passed alike everywhere.
template <int kWidth, class Float>
INHABIT_INLINE void sigmoid(Float& x) {
  typedef int32_t Int __attribute__((vector_size(kWidth * sizeof(float))));
  Float y = -x;
  y = y > 87.0F ? (y - y + 87.0F) : y;
  y = y < -87.0F ? (y - y - 87.0F) : y;
  const Float shifted = y * 1.44269504F + 12582912.0F;  // 1.5 * 2^23: the low bits are now the rounded quotient
  const Float n = shifted - 12582912.0F;
  const Float r = (y - n * 0.693359375F) + n * 2.12194440e-4F;
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
  x = 1.0F / (1.0F + p * scale);
}

template <int kWidth>
INHABIT_INLINE void update(int64_t hidden, const float* in, const float* rec, const float* state, float* next) {
  typedef float Float __attribute__((vector_size(kWidth * sizeof(float))));
  // Copies, because rows need not be aligned; they compile to plain loads.
  const auto add = [](Float& to, const float* from) {
    Float v;
    std::memcpy(&v, from, sizeof(v));
    to += v;
  };
  int64_t i = 0;
  for (; i + kWidth <= hidden; i += kWidth) {
    Float reset = {}, keep = {}, candidate = {}, recurrent = {}, before = {};
    add(reset, in + i);
    add(reset, rec + i);
    sigmoid<kWidth>(reset);
    add(keep, in + hidden + i);
    add(keep, rec + hidden + i);
    sigmoid<kWidth>(keep);
    add(candidate, in + 2 * hidden + i);
    add(recurrent, rec + 2 * hidden + i);
    candidate = 2.0F * (candidate + reset * recurrent);
    sigmoid<kWidth>(candidate);  // tanh(x) = 2 sigmoid(2 x) - 1
    candidate = 2.0F * candidate - 1.0F;
    add(before, state + i);
    const Float value = candidate + keep * (before - candidate);
    std::memcpy(next + i, &value, sizeof(value));
  }
  const auto scalar = [](float x) { return 1.0F / (1.0F + std::exp(-x)); };
  for (; i < hidden; ++i) {
    const float reset = scalar(in[i] + rec[i]), keep = scalar(in[hidden + i] + rec[hidden + i]);
    const float candidate = std::tanh(in[2 * hidden + i] + reset * rec[2 * hidden + i]);
    next[i] = candidate + keep * (state[i] - candidate);
  }
}

INHABIT_TARGET_AVX512 void update_avx512(int64_t n, const float* in, const float* rec, const float* state,
                                         float* next) {
  update<16>(n, in, rec, state, next);
}
INHABIT_TARGET_AVX2 void update_avx2(int64_t n, const float* in, const float* rec, const float* state, float* next) {
  update<8>(n, in, rec, state, next);
}

}  // namespace

void gru_update(int64_t hidden, const float* input_gates, const float* state_gates, const float* state, float* next) {
  switch (simd_level()) {
    case Simd::kAvx512:
      return update_avx512(hidden, input_gates, state_gates, state, next);
    case Simd::kAvx2:
      return update_avx2(hidden, input_gates, state_gates, state, next);
    case Simd::kBaseline:
      return update<4>(hidden, input_gates, state_gates, state, next);
  }
}

}  // namespace inhabit::nn
