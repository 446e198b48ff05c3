#include "inhabit/nn/row_products_kernel.h"

#include <cstring>

#include "inhabit/math/simd.h"

namespace inhabit::nn {
namespace {

/// `rows` rows of y, kVectors vectors of kWidth columns each, held in registers while the input channels go by.
template <int kWidth, int kVectors, int kRows>
INHABIT_INLINE void tile(const float* w, int64_t depth, const float* const* x, float* const* y) {
  typedef float vec __attribute__((vector_size(kWidth * sizeof(float)), aligned(4), may_alias));
  vec sum[kRows][kVectors];
#pragma GCC unroll 8
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 8
    for (int v = 0; v < kVectors; ++v) sum[r][v] = *reinterpret_cast<const vec*>(y[r] + v * kWidth);
  }
  for (int64_t c = 0; c < depth; ++c, w += kColumnBlock) {
    vec weight[kVectors];
#pragma GCC unroll 8
    for (int v = 0; v < kVectors; ++v) weight[v] = *reinterpret_cast<const vec*>(w + v * kWidth);
#pragma GCC unroll 8
    for (int r = 0; r < kRows; ++r) {
      const float value = x[r][c];
#pragma GCC unroll 8
      for (int v = 0; v < kVectors; ++v) sum[r][v] += value * weight[v];
    }
  }
#pragma GCC unroll 8
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 8
    for (int v = 0; v < kVectors; ++v) *reinterpret_cast<vec*>(y[r] + v * kWidth) = sum[r][v];
  }
}

template <int kWidth, int kVectors, int kRows>
INHABIT_INLINE void tiles_across(const float* w, int64_t depth, const float* const* x, float* const* y) {
  for (int64_t column = 0; column < kColumnBlock; column += kWidth * kVectors) {
    float* target[kRows];
    for (int r = 0; r < kRows; ++r) target[r] = y[r] + column;
    tile<kWidth, kVectors, kRows>(w + column, depth, x, target);
  }
}

template <int kWidth, int kVectors>
INHABIT_INLINE void accumulate(const PackedMatrix& w, int64_t first, int64_t last, int64_t depth, const float* x,
                               int64_t x_stride, const int32_t* from, const int32_t* to, int64_t count, float* y) {
  constexpr int kRows = 6;
  constexpr int64_t kDepth = 128;  // so much of a column block (32 KB) stays in the first-level cache for all rows
  const int64_t y_stride = w.stride();
  const float* source[kRows];
  float* target[kRows];
  for (int64_t column = first; column < last; column += kColumnBlock) {
    for (int64_t done = 0; done < depth; done += kDepth) {
      const float* weights = w.data.data() + column * w.in + done * kColumnBlock;
      const int64_t some = depth - done < kDepth ? depth - done : kDepth;
      for (int64_t i = 0; i < count;) {
        const int64_t got = count - i < kRows ? count - i : kRows;
        for (int64_t r = 0; r < got; ++r) {
          source[r] = x + (from != nullptr ? from[i + r] : i + r) * x_stride + done;
          target[r] = y + (to != nullptr ? to[i + r] : i + r) * y_stride + column;
        }
        i += got;
        int64_t row = 0;
        if (got == kRows) {
          tiles_across<kWidth, kVectors, kRows>(weights, some, source, target);
          continue;
        }
        if (got >= 3) {
          tiles_across<kWidth, kVectors, 3>(weights, some, source, target);
          row += 3;
        }
        for (; row < got; ++row) tiles_across<kWidth, kVectors, 1>(weights, some, source + row, target + row);
      }
    }
  }
}

INHABIT_TARGET_AVX512 void accumulate_avx512(const PackedMatrix& w, int64_t first, int64_t last, int64_t depth,
                                             const float* x, int64_t x_stride, const int32_t* from, const int32_t* to,
                                             int64_t count, float* y) {
  accumulate<16, 4>(w, first, last, depth, x, x_stride, from, to, count, y);
}
INHABIT_TARGET_AVX2 void accumulate_avx2(const PackedMatrix& w, int64_t first, int64_t last, int64_t depth,
                                         const float* x, int64_t x_stride, const int32_t* from, const int32_t* to,
                                         int64_t count, float* y) {
  accumulate<8, 2>(w, first, last, depth, x, x_stride, from, to, count, y);
}

}  // namespace

PackedMatrix pack_matrix(const float* entry, int64_t in, int64_t out, int64_t in_step, int64_t out_step) {
  PackedMatrix w;
  w.in = in;
  w.out = out;
  w.data.assign(static_cast<size_t>(in * w.stride()), 0.0F);
  for (int64_t first = 0; first < out; first += kColumnBlock) {
    const int64_t columns = out - first < kColumnBlock ? out - first : kColumnBlock;
    for (int64_t i = 0; i < in; ++i) {
      float* row = w.data.data() + first * in + i * kColumnBlock;
      for (int64_t o = 0; o < columns; ++o) row[o] = entry[i * in_step + (first + o) * out_step];
    }
  }
  return w;
}

void accumulate_rows(const PackedMatrix& w, int64_t depth, const float* x, int64_t x_stride, const int32_t* from,
                     const int32_t* to, int64_t count, float* y) {
  accumulate_columns(w, 0, w.stride(), depth, x, x_stride, from, to, count, y);
}

void accumulate_columns(const PackedMatrix& w, int64_t first, int64_t last, int64_t depth, const float* x,
                        int64_t x_stride, const int32_t* from, const int32_t* to, int64_t count, float* y) {
  for_simd_level(accumulate_avx512, accumulate_avx2, accumulate<4, 2>)(w, first, last, depth, x, x_stride, from, to,
                                                                       count, y);
}

}  // namespace inhabit::nn
