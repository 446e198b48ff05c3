#pragma once
#include <Eigen/Geometry>
#include <cmath>

namespace inhabit {

// Rotations of single joints, in double precision, for code that works frame by frame (rotation.h has the batched
// ones).

/// Axis-angle (radians) to unit quaternion.
inline Eigen::Quaterniond quaternion_of(const Eigen::Vector3d& axis_angle) {
  const double t2 = axis_angle.squaredNorm();
  const double t = std::sqrt(t2);
  const double scale = t2 < 1e-8 ? 0.5 - t2 / 48 : std::sin(0.5 * t) / t;
  const Eigen::Vector3d v = scale * axis_angle;
  return {std::cos(0.5 * t), v.x(), v.y(), v.z()};
}

/// Unit quaternion to axis-angle, angle in [0, pi].
inline Eigen::Vector3d axis_angle_of(const Eigen::Quaterniond& q) {
  const Eigen::Vector3d v = q.w() < 0 ? Eigen::Vector3d(-q.vec()) : Eigen::Vector3d(q.vec());
  const double w = std::abs(q.w()), s = v.norm();
  return s < 1e-8 ? Eigen::Vector3d(2 * v) : Eigen::Vector3d(2 * std::atan2(s, w) / s * v);
}

/// The matrix of v x.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// Derivative of log(exp(a) exp(d)) by d at d = 0, of axis-angle vectors: the inverse of SO(3)'s right Jacobian. Its
/// transpose is that of log(exp(d) exp(a)).
inline Eigen::Matrix3d log_derivative(const Eigen::Vector3d& a) {
  const double angle2 = a.squaredNorm(), angle = std::sqrt(angle2);
  const Eigen::Matrix3d k = cross_matrix(a);
  const double second = angle2 < 1e-6 ? 1.0 / 12 + angle2 / 720 : 1 / angle2 - 0.5 / (angle * std::tan(0.5 * angle));
  return Eigen::Matrix3d::Identity() + 0.5 * k + second * k * k;
}

/// The rotation that carries the frame (x along `along`, y towards `side`) of one body onto that of another. `side`
/// need not be orthogonal to `along`; where it is parallel any rotation that carries `along` over is returned.
Eigen::Quaterniond rotation_between_frames(const Eigen::Vector3d& from_along, const Eigen::Vector3d& from_side,
                                           const Eigen::Vector3d& to_along, const Eigen::Vector3d& to_side);

}  // namespace inhabit
