#pragma once
#include <Eigen/Core>
#include <cmath>

namespace inhabit {

// On the ground a point is (x, z) and a heading is an angle from +Z towards +X, a rotation about +Y. Tensors of
// headings: yaw_of_left and yaw_matrix (rotation.h); a person's: motion/canonical.h.

/// A point (x, y, z) seen from above: (x, z).
inline Eigen::Vector2d on_ground(const Eigen::Vector3d& point) { return {point.x(), point.z()}; }
/// Unit vector of a heading, (x, z).
inline Eigen::Vector2d ahead_of(double heading) { return {std::sin(heading), std::cos(heading)}; }
/// Unit vector to the left of a heading, (x, z).
inline Eigen::Vector2d left_of(double heading) { return {std::cos(heading), -std::sin(heading)}; }
/// Heading in [-pi, pi] of a direction (x, z) of any length but 0.
inline double heading_of(const Eigen::Vector2d& direction) { return std::atan2(direction.x(), direction.y()); }
/// Heading of somebody whose left is along (x, z).
template <class Scalar>
Scalar heading_of_left(Scalar x, Scalar z) {
  return std::atan2(-z, x);
}
/// The same angle in [-pi, pi].
inline double wrapped(double angle) { return std::remainder(angle, 2 * M_PI); }

}  // namespace inhabit
