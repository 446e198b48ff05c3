#pragma once
#include <cstdint>
#include <vector>

namespace inhabit::nn {

/// Columns handled together: rows that accumulate_rows() writes are padded to a multiple of this.
inline constexpr int64_t kColumnBlock = 64;

inline int64_t padded_columns(int64_t columns) { return (columns + kColumnBlock - 1) / kColumnBlock * kColumnBlock; }

/// A matrix (in, out) in the order accumulate_rows() reads it: blocks of 64 columns, zero beyond the last.
struct PackedMatrix {
  int64_t in = 0, out = 0;
  std::vector<float> data;

  int64_t stride() const { return padded_columns(out); }
};

/// @param entry first element; that of row i and column o lies at entry[i * in_step + o * out_step].
PackedMatrix pack_matrix(const float* entry, int64_t in, int64_t out, int64_t in_step, int64_t out_step);

/// y[to[i]] += x[from[i]] w for i < count, where rows of x are `x_stride` apart and rows of y w.stride() apart: gather,
/// product and scatter in one, no row stored in between.
/// @param from, to row numbers, or nullptr for 0, 1, 2...; `to` must not repeat a row.
/// @param depth only the first `depth` of w.in input channels are read (the rest being zero).
void accumulate_rows(const PackedMatrix& w, int64_t depth, const float* x, int64_t x_stride, const int32_t* from,
                     const int32_t* to, int64_t count, float* y);

/// The same for columns [first, last) of w alone, multiples of kColumnBlock, so that threads can share a product and
/// each reads only its part of w.
void accumulate_columns(const PackedMatrix& w, int64_t first, int64_t last, int64_t depth, const float* x,
                        int64_t x_stride, const int32_t* from, const int32_t* to, int64_t count, float* y);

}  // namespace inhabit::nn
