#pragma once
#include <cmath>

namespace inhabit::refine {

// Weights of terms are 1 / sigma^2, sigma in the unit of the residual.
/// The weight of a term whose residual has standard deviation `sigma`.
constexpr double weight_of(double sigma) { return 1 / (sigma * sigma); }
/// A degree in radians.
inline constexpr double kDegree = M_PI / 180;
inline constexpr double kRotationJerk = 120,  ///< rad/s^3, of a rotation in motion without noise
    kPlaceJerk = 60;                          ///< m/s^3, of a joint's place in it

}  // namespace inhabit::refine
