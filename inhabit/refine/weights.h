#pragma once
#include <cmath>

namespace inhabit::refine {

// Weights of terms are 1 / sigma^2, sigma in the unit of the residual.
constexpr double weight_of(double sigma) { return 1 / (sigma * sigma); }
inline constexpr double kDegree = M_PI / 180;
inline constexpr double kRotationJerk = 120, kPlaceJerk = 60;  ///< rad/s^3, m/s^3: of motion without noise

}  // namespace inhabit::refine
