#pragma once

namespace inhabit {

/// 0 up to 0, 1 from 1 on, and in between the cubic that joins them without a bend.
inline double smooth_step(double x) { return x <= 0 ? 0 : x >= 1 ? 1 : x * x * (3 - 2 * x); }

}  // namespace inhabit
