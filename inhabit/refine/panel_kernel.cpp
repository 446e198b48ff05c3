#include "inhabit/refine/panel_kernel.h"

#include <cmath>

#include "inhabit/math/simd.h"

namespace inhabit::refine {
namespace {

template <int kWidth>
struct PanelVector {
  typedef double type __attribute__((vector_size(kWidth * sizeof(double)), aligned(8), may_alias));
  static INHABIT_INLINE type& at(double* x) { return *reinterpret_cast<type*>(x); }
  static INHABIT_INLINE const type& at(const double* x) { return *reinterpret_cast<const type*>(x); }
};

/// kRows rows of c, kVectors vectors of kWidth columns each, held in registers while the depth goes by.
template <int kWidth, int kVectors, int kRows>
INHABIT_INLINE void product_tile(const double* a, const double* b, int64_t stride, int64_t depth, double* c,
                                 int64_t c_stride) {
  using V = PanelVector<kWidth>;
  typename V::type sum[kRows][kVectors];
#pragma GCC unroll 8
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 8
    for (int v = 0; v < kVectors; ++v) sum[r][v] = V::at(c + r * c_stride + v * kWidth);
  }
  for (int64_t i = 0; i < depth; ++i, a += stride, b += stride) {
    typename V::type right[kVectors];
#pragma GCC unroll 8
    for (int v = 0; v < kVectors; ++v) right[v] = V::at(b + v * kWidth);
#pragma GCC unroll 8
    for (int r = 0; r < kRows; ++r) {
      const double left = a[r];
#pragma GCC unroll 8
      for (int v = 0; v < kVectors; ++v) sum[r][v] -= left * right[v];
    }
  }
#pragma GCC unroll 8
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 8
    for (int v = 0; v < kVectors; ++v) V::at(c + r * c_stride + v * kWidth) = sum[r][v];
  }
}

/// One row group across all columns from `first` on.
template <int kWidth, int kVectors, int kRows>
INHABIT_INLINE void product_rows(const double* a, const double* b, int64_t stride, int64_t depth, double* c,
                                 int64_t c_stride, int64_t first, int64_t columns) {
  int64_t w = first;
  for (; w + kWidth * kVectors <= columns; w += kWidth * kVectors)
    product_tile<kWidth, kVectors, kRows>(a, b + w, stride, depth, c + w, c_stride);
  for (; w < columns; w += kPanelWidth) product_tile<kPanelWidth, 1, kRows>(a, b + w, stride, depth, c + w, c_stride);
}

template <int kWidth, int kVectors>
INHABIT_INLINE void products(const double* a, const double* b, int64_t stride, int64_t depth, double* c,
                             int64_t c_stride, int64_t rows, int64_t columns, bool upper) {
  constexpr int kRows = 6;
  for (int64_t r = 0; r < rows;) {
    const int64_t first = upper ? r / kPanelWidth * kPanelWidth : 0;
    double* to = c + r * c_stride;
    if (rows - r >= kRows) {
      product_rows<kWidth, kVectors, kRows>(a + r, b, stride, depth, to, c_stride, first, columns);
      r += kRows;
    } else if (rows - r >= 3) {
      product_rows<kWidth, kVectors, 3>(a + r, b, stride, depth, to, c_stride, first, columns);
      r += 3;
    } else {
      product_rows<kWidth, kVectors, 1>(a + r, b, stride, depth, to, c_stride, first, columns);
      r += 1;
    }
  }
}

/// Rows wait for all earlier ones at once, in groups, so that each is read and written once.
template <int kWidth, int kVectors>
INHABIT_INLINE bool factor_rows(double* panel, int64_t stride, int64_t rows, int64_t columns) {
  using V = PanelVector<kPanelWidth>;
  constexpr int64_t kGroup = 6;
  for (int64_t first = 0; first < rows; first += kGroup) {
    const int64_t last = first + kGroup < rows ? first + kGroup : rows;
    const int64_t left = first / kPanelWidth * kPanelWidth;
    products<kWidth, kVectors>(panel + first, panel + left, stride, first, panel + first * stride + left, stride,
                               last - first, columns - left, false);
    for (int64_t i = first; i < last; ++i) {
      double* row = panel + i * stride;
      if (!(row[i] > 0) || !std::isfinite(row[i])) return false;
      const double scale = 1 / std::sqrt(row[i]);
      for (int64_t w = left; w < columns; w += kPanelWidth) V::at(row + w) *= scale;
      for (int64_t j = i + 1; j < last; ++j) {
        double* other = panel + j * stride;
        const double factor = row[j];
        for (int64_t w = left; w < columns; w += kPanelWidth) V::at(other + w) -= factor * V::at(row + w);
      }
    }
  }
  return true;
}

INHABIT_TARGET_AVX512 void products_avx512(const double* a, const double* b, int64_t stride, int64_t depth, double* c,
                                           int64_t c_stride, int64_t rows, int64_t columns, bool upper) {
  products<8, 3>(a, b, stride, depth, c, c_stride, rows, columns, upper);
}
INHABIT_TARGET_AVX2 void products_avx2(const double* a, const double* b, int64_t stride, int64_t depth, double* c,
                                       int64_t c_stride, int64_t rows, int64_t columns, bool upper) {
  products<4, 2>(a, b, stride, depth, c, c_stride, rows, columns, upper);
}
INHABIT_TARGET_AVX512 bool factor_avx512(double* panel, int64_t stride, int64_t rows, int64_t columns) {
  return factor_rows<8, 3>(panel, stride, rows, columns);
}
INHABIT_TARGET_AVX2 bool factor_avx2(double* panel, int64_t stride, int64_t rows, int64_t columns) {
  return factor_rows<4, 2>(panel, stride, rows, columns);
}

}  // namespace

void subtract_products(const double* a, const double* b, int64_t stride, int64_t depth, double* c, int64_t c_stride,
                       int64_t rows, int64_t columns, bool upper) {
  switch (simd_level()) {
    case Simd::kAvx512:
      return products_avx512(a, b, stride, depth, c, c_stride, rows, columns, upper);
    case Simd::kAvx2:
      return products_avx2(a, b, stride, depth, c, c_stride, rows, columns, upper);
    case Simd::kBaseline:
      return products<2, 2>(a, b, stride, depth, c, c_stride, rows, columns, upper);
  }
}

bool factor_panel(double* panel, int64_t stride, int64_t rows, int64_t columns) {
  switch (simd_level()) {
    case Simd::kAvx512:
      return factor_avx512(panel, stride, rows, columns);
    case Simd::kAvx2:
      return factor_avx2(panel, stride, rows, columns);
    case Simd::kBaseline:
      break;
  }
  return factor_rows<2, 2>(panel, stride, rows, columns);
}

// Substitution waits for memory, not for arithmetic: one level is enough.

void substitute_forward(const double* panel, int64_t stride, int64_t rows, int64_t own, int64_t others, double* x,
                        double* rest) {
  using V = PanelVector<kPanelWidth>;
  for (int64_t i = 0; i < rows; ++i, panel += stride) {
    const double y = x[i] / panel[i];
    x[i] = y;
    int64_t w = i + 1;
    for (; w < own && w % kPanelWidth != 0; ++w) x[w] -= y * panel[w];
    for (; w < own; w += kPanelWidth) V::at(x + w) -= y * V::at(panel + w);
    for (w = 0; w < others; w += kPanelWidth) V::at(rest + w) -= y * V::at(panel + own + w);
  }
}

void substitute_backward(const double* panel, int64_t stride, int64_t rows, int64_t own, int64_t others, double* y,
                         const double* rest) {
  using V = PanelVector<kPanelWidth>;
  for (int64_t i = rows - 1; i >= 0; --i) {
    const double* row = panel + i * stride;
    if (i > 1)  // rows are read backwards: asked for two ahead, they are there in time
      for (int64_t w = 0; w < own + others; w += 8) __builtin_prefetch(row - 2 * stride + w);
    V::type sums = {};
    double sum = 0;
    int64_t w = i + 1;
    for (; w < own && w % kPanelWidth != 0; ++w) sum += row[w] * y[w];
    for (; w < own; w += kPanelWidth) sums += V::at(row + w) * V::at(y + w);
    for (w = 0; w < others; w += kPanelWidth) sums += V::at(row + own + w) * V::at(rest + w);
    for (int64_t v = 0; v < kPanelWidth; ++v) sum += sums[v];
    y[i] = (y[i] - sum) / row[i];
  }
}

}  // namespace inhabit::refine
