#include "inhabit/nn/gru_kernel.h"

#include <cmath>
#include <cstring>

#include "inhabit/math/simd.h"
#include "inhabit/nn/vector_exp.h"

namespace inhabit::nn {
namespace {

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
    vector_sigmoid<kWidth>(reset);
    add(keep, in + hidden + i);
    add(keep, rec + hidden + i);
    vector_sigmoid<kWidth>(keep);
    add(candidate, in + 2 * hidden + i);
    add(recurrent, rec + 2 * hidden + i);
    candidate = candidate + reset * recurrent;
    vector_tanh<kWidth>(candidate);
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
  for_simd_level(update_avx512, update_avx2, update<4>)(hidden, input_gates, state_gates, state, next);
}

}  // namespace inhabit::nn
