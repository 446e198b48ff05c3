#pragma once
#include <Eigen/Geometry>

namespace inhabit {

/// The point of triangle a, b, c that is nearest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
template <typename Scalar>
Eigen::Matrix<Scalar, 3, 1> closest_on_triangle(const Eigen::Matrix<Scalar, 3, 1>& p,
                                                const Eigen::Matrix<Scalar, 3, 1>& a,
                                                const Eigen::Matrix<Scalar, 3, 1>& b,
                                                const Eigen::Matrix<Scalar, 3, 1>& c) {
  using Vector = Eigen::Matrix<Scalar, 3, 1>;
  const Vector ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const Scalar d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return a;
  if (d3 >= 0 && d4 <= d3) return b;
  if (d6 >= 0 && d5 <= d6) return c;
  const Scalar vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 - d3 > 0) return a + d1 / (d1 - d3) * ab;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 - d6 > 0) return a + d2 / (d2 - d6) * ac;
  const Scalar e = d4 - d3, f = d5 - d6;
  if (va <= 0 && e >= 0 && f >= 0 && e + f > 0) return b + e / (e + f) * (c - b);
  const Scalar sum = va + vb + vc;
  if (!(std::abs(sum) > 0)) return a;
  return a + vb / sum * ab + vc / sum * ac;
}

}  // namespace inhabit
