#pragma once
#include <cstdint>

namespace inhabit::refine {

// What a block-banded Cholesky factorisation does with rows of Real, double or float. A panel is a block row: `rows`
// rows, `stride` numbers apart, whose number of columns is a multiple of kPanelWidth, zeros where there is nothing.

template <class Real>
inline constexpr int64_t kPanelWidth = 32 / sizeof(Real);

template <class Real>
inline constexpr int64_t padded_to_panel(int64_t columns) {
  return (columns + kPanelWidth<Real> - 1) / kPanelWidth<Real> * kPanelWidth<Real>;
}

/// c -= aᵀ b for a (depth, rows) and b (depth, columns), rows of both `stride` apart. Where `upper`, only what lies on
/// or right of the diagonal of c is wanted: the rest may hold anything.
template <class Real>
void subtract_products(const Real* a, const Real* b, int64_t stride, int64_t depth, Real* c, int64_t c_stride,
                       int64_t rows, int64_t columns, bool upper);

/// A panel [P Q], P symmetric in its first columns, of which the upper triangle counts, becomes [R S] with Rᵀ R = P and
/// Rᵀ S = Q, R upper triangular; what lies left of its diagonal may hold anything. False where P is not positive
/// definite.
template <class Real>
bool factor_panel(Real* panel, int64_t stride, int64_t rows, int64_t columns);

/// For a panel [R S], R in the first `own` columns, S in `others` more: x, of the panel's rows, becomes y with Rᵀ y =
/// x, and rest -= Sᵀ y.
template <class Real>
void substitute_forward(const Real* panel, int64_t stride, int64_t rows, int64_t own, int64_t others, Real* x,
                        Real* rest);

/// y becomes x with R x = y - S rest.
template <class Real>
void substitute_backward(const Real* panel, int64_t stride, int64_t rows, int64_t own, int64_t others, Real* y,
                         const Real* rest);

}  // namespace inhabit::refine
