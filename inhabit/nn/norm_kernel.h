#pragma once
#include <cstdint>

namespace inhabit::nn {

// Passes over rows of numbers, `stride` floats from one row to the next: what a group norm and its activation are made
// of.

/// sums[c] = sum over rows of (x[r][c] - centre)^2, or of x[r][c] itself where `squared` is false, for c < columns.
void column_sums(const float* x, int64_t stride, int64_t rows, int64_t columns, float centre, bool squared,
                 float* sums);

/// y[r][c] = mish(x[r][c] scale[c] + shift[c]), plus add[r][c] where `add` is not nullptr.
/// mish(v) = v tanh(log(1 + exp(v))), good to some 4e-7.
void scaled_mish(const float* x, int64_t x_stride, int64_t rows, int64_t columns, const float* scale,
                 const float* shift, const float* add, int64_t add_stride, float* y, int64_t y_stride);

}  // namespace inhabit::nn
