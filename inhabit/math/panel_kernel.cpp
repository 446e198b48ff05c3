#include "inhabit/math/panel_kernel.h"

#include <cmath>

#include "inhabit/math/simd.h"

namespace inhabit {
namespace {

constexpr int64_t kGroup = 6;  // rows of a tile

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
  for (const double* const end = a + depth * stride; a != end; a += stride, b += stride) {
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

/// All rows of c in the columns of one tile.
template <int kWidth, int kVectors>
INHABIT_INLINE void product_columns(const double* a, const double* b, int64_t stride, int64_t depth, double* c,
                                    int64_t c_stride, int64_t rows) {
  int64_t r = 0;
  for (; r + kGroup <= rows; r += kGroup)
    product_tile<kWidth, kVectors, kGroup>(a + r, b, stride, depth, c + r * c_stride, c_stride);
  for (; r + 3 <= rows; r += 3) product_tile<kWidth, kVectors, 3>(a + r, b, stride, depth, c + r * c_stride, c_stride);
  for (; r < rows; ++r) product_tile<kWidth, kVectors, 1>(a + r, b, stride, depth, c + r * c_stride, c_stride);
}

/// Columns go by in the outer loop: those of b that a tile needs stay in the nearest cache for all rows.
template <int kWidth, int kVectors>
INHABIT_INLINE void products(const double* a, const double* b, int64_t stride, int64_t depth, double* c,
                             int64_t c_stride, int64_t rows, int64_t columns, bool upper) {
  constexpr int64_t kTile = kWidth * kVectors;
  const auto down_to = [&](int64_t end) { return upper && end < rows ? end : rows; };
  int64_t w = 0;
  for (; w + kTile <= columns; w += kTile)
    product_columns<kWidth, kVectors>(a, b + w, stride, depth, c + w, c_stride, down_to(w + kTile));
  for (; w < columns; w += kPanelWidth)
    product_columns<kPanelWidth, 1>(a, b + w, stride, depth, c + w, c_stride, down_to(w + kPanelWidth));
}

/// Rows of a group, which all earlier groups are subtracted from, among themselves.
INHABIT_INLINE void eliminate_in_group(double* panel, int64_t stride, int64_t i, int64_t last, int64_t left,
                                       int64_t columns) {
  using V = PanelVector<kPanelWidth>;
  const double* row = panel + i * stride;
  for (int64_t j = i + 1; j < last; ++j) {
    double* other = panel + j * stride;
    const double factor = row[j];
    for (int64_t w = left; w < columns; w += kPanelWidth) V::at(other + w) -= factor * V::at(row + w);
  }
}

/// The panel's first `rows` columns. Rows wait for all earlier ones at once, in groups, so that each is read and
/// written once.
template <int kWidth, int kVectors>
INHABIT_INLINE bool factor_square(double* panel, int64_t stride, int64_t rows) {
  using V = PanelVector<kPanelWidth>;
  const int64_t columns = padded_to_panel(rows);
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
      eliminate_in_group(panel, stride, i, last, left, columns);
    }
  }
  return true;
}

/// S of some of the panel's columns, [w, w + width), from Q and R.
template <int kWidth, int kVectors>
INHABIT_INLINE void factor_beside(double* panel, int64_t stride, int64_t rows, int64_t w) {
  using V = PanelVector<kWidth>;
  for (int64_t first = 0; first < rows; first += kGroup) {
    const int64_t last = first + kGroup < rows ? first + kGroup : rows;
    product_columns<kWidth, kVectors>(panel + first, panel + w, stride, first, panel + first * stride + w, stride,
                                      last - first);
    for (int64_t i = first; i < last; ++i) {
      double* row = panel + i * stride;
      const double scale = 1 / row[i];
      typename V::type own[kVectors];
#pragma GCC unroll 8
      for (int v = 0; v < kVectors; ++v) own[v] = V::at(row + w + v * kWidth) = scale * V::at(row + w + v * kWidth);
      for (int64_t j = i + 1; j < last; ++j) {
        double* other = panel + j * stride + w;
        const double factor = row[j];
#pragma GCC unroll 8
        for (int v = 0; v < kVectors; ++v) V::at(other + v * kWidth) -= factor * own[v];
      }
    }
  }
}

template <int kWidth, int kVectors>
INHABIT_INLINE bool factor_rows(double* panel, int64_t stride, int64_t rows, int64_t columns) {
  constexpr int64_t kTile = kWidth * kVectors;
  if (!factor_square<kWidth, kVectors>(panel, stride, rows)) return false;
  int64_t w = padded_to_panel(rows);
  for (; w + kTile <= columns; w += kTile) factor_beside<kWidth, kVectors>(panel, stride, rows, w);
  for (; w < columns; w += kPanelWidth) factor_beside<kPanelWidth, 1>(panel, stride, rows, w);
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

/// x[w] -= y row[w] for w in [first, last), of which last is a multiple of kPanelWidth.
template <int kWidth>
INHABIT_INLINE void subtract_row(double* x, const double* row, double y, int64_t first, int64_t last) {
  using Wide = PanelVector<kWidth>;
  using Narrow = PanelVector<kPanelWidth>;
  int64_t w = first;
  for (; w < last && w % kPanelWidth != 0; ++w) x[w] -= y * row[w];
  for (; w + kWidth <= last; w += kWidth) Wide::at(x + w) -= y * Wide::at(row + w);
  for (; w < last; w += kPanelWidth) Narrow::at(x + w) -= y * Narrow::at(row + w);
}

/// The sum of x[w] row[w], likewise.
template <int kWidth>
INHABIT_INLINE double row_product(const double* x, const double* row, int64_t first, int64_t last) {
  using Wide = PanelVector<kWidth>;
  typename Wide::type sums = {};
  double sum = 0;
  int64_t w = first;
  for (; w < last && w % kPanelWidth != 0; ++w) sum += x[w] * row[w];
  for (; w + kWidth <= last; w += kWidth) sums += Wide::at(x + w) * Wide::at(row + w);
  for (; w < last; ++w) sum += x[w] * row[w];
  for (int v = 0; v < kWidth; ++v) sum += sums[v];
  return sum;
}

template <int kWidth>
INHABIT_INLINE void forward(const double* panel, int64_t stride, int64_t rows, int64_t own, int64_t others, double* x,
                            double* rest) {
  for (int64_t i = 0; i < rows; ++i, panel += stride) {
    const double y = x[i] / panel[i];
    x[i] = y;
    subtract_row<kWidth>(x, panel, y, i + 1, own);
    subtract_row<kWidth>(rest, panel + own, y, 0, others);
  }
}

template <int kWidth>
INHABIT_INLINE void backward(const double* panel, int64_t stride, int64_t rows, int64_t own, int64_t others, double* y,
                             const double* rest) {
  for (int64_t i = rows - 1; i >= 0; --i) {
    const double* row = panel + i * stride;
    if (i > 1)  // rows are read backwards: asked for two ahead, they are there in time
      for (int64_t w = 0; w < own + others; w += 8) __builtin_prefetch(row - 2 * stride + w);
    const double sum = row_product<kWidth>(y, row, i + 1, own) + row_product<kWidth>(rest, row + own, 0, others);
    y[i] = (y[i] - sum) / row[i];
  }
}

INHABIT_TARGET_AVX512 void forward_avx512(const double* panel, int64_t stride, int64_t rows, int64_t own,
                                          int64_t others, double* x, double* rest) {
  forward<8>(panel, stride, rows, own, others, x, rest);
}
INHABIT_TARGET_AVX2 void forward_avx2(const double* panel, int64_t stride, int64_t rows, int64_t own, int64_t others,
                                      double* x, double* rest) {
  forward<4>(panel, stride, rows, own, others, x, rest);
}
INHABIT_TARGET_AVX512 void backward_avx512(const double* panel, int64_t stride, int64_t rows, int64_t own,
                                           int64_t others, double* y, const double* rest) {
  backward<8>(panel, stride, rows, own, others, y, rest);
}
INHABIT_TARGET_AVX2 void backward_avx2(const double* panel, int64_t stride, int64_t rows, int64_t own, int64_t others,
                                       double* y, const double* rest) {
  backward<4>(panel, stride, rows, own, others, y, rest);
}

}  // namespace

void subtract_products(const double* a, const double* b, int64_t stride, int64_t depth, double* c, int64_t c_stride,
                       int64_t rows, int64_t columns, bool upper) {
  for_simd_level(products_avx512, products_avx2, products<2, 2>)(a, b, stride, depth, c, c_stride, rows, columns,
                                                                 upper);
}

bool factor_panel(double* panel, int64_t stride, int64_t rows, int64_t columns) {
  return for_simd_level(factor_avx512, factor_avx2, factor_rows<2, 2>)(panel, stride, rows, columns);
}

void substitute_forward(const double* panel, int64_t stride, int64_t rows, int64_t own, int64_t others, double* x,
                        double* rest) {
  for_simd_level(forward_avx512, forward_avx2, forward<2>)(panel, stride, rows, own, others, x, rest);
}

void substitute_backward(const double* panel, int64_t stride, int64_t rows, int64_t own, int64_t others, double* y,
                         const double* rest) {
  for_simd_level(backward_avx512, backward_avx2, backward<2>)(panel, stride, rows, own, others, y, rest);
}

}  // namespace inhabit
