#pragma once
#include <cstdint>

namespace inhabit {

// What a block-banded Cholesky factorisation does with rows of doubles. A panel is a block row: `rows` rows, `stride`
// numbers apart, whose number of columns is a multiple of kPanelWidth, zeros where there is nothing.

inline constexpr int64_t kPanelWidth = 4;

inline constexpr int64_t padded_to_panel(int64_t columns) {
  return (columns + kPanelWidth - 1) / kPanelWidth * kPanelWidth;
}

/// c -= aᵀ b for a (depth, rows) and b (depth, columns), rows of both `stride` apart. Where `upper`, only what lies on
/// or right of the diagonal of c is wanted: the rest may hold anything.
void subtract_products(const double* a, const double* b, int64_t stride, int64_t depth, double* c, int64_t c_stride,
                       int64_t rows, int64_t columns, bool upper);

/// A panel [P Q], P symmetric in its first columns, of which the upper triangle counts, becomes [R S] with Rᵀ R = P and
/// Rᵀ S = Q, R upper triangular; what lies left of its diagonal may hold anything. False where P is not positive
/// definite.
bool factor_panel(double* panel, int64_t stride, int64_t rows, int64_t columns);

/// For a panel [R S], R in the first `own` columns, S in `others` more: x, of the panel's rows, becomes y with Rᵀ y =
/// x, and rest -= Sᵀ y.
void substitute_forward(const double* panel, int64_t stride, int64_t rows, int64_t own, int64_t others, double* x,
                        double* rest);

/// y becomes x with R x = y - S rest.
void substitute_backward(const double* panel, int64_t stride, int64_t rows, int64_t own, int64_t others, double* y,
                         const double* rest);

}  // namespace inhabit
