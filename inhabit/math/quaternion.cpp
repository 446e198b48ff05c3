#include "inhabit/math/quaternion.h"

namespace inhabit {
namespace {

Eigen::Matrix3d frame(const Eigen::Vector3d& along, const Eigen::Vector3d& side) {
  Eigen::Matrix3d m;
  m.col(0) = along.normalized();
  Eigen::Vector3d y = side - side.dot(m.col(0)) * m.col(0);
  if (y.squaredNorm() < 1e-16 * (1 + side.squaredNorm())) y = m.col(0).unitOrthogonal();
  m.col(1) = y.normalized();
  m.col(2) = m.col(0).cross(m.col(1));
  return m;
}

}  // namespace

Eigen::Quaterniond rotation_between_frames(const Eigen::Vector3d& from_along, const Eigen::Vector3d& from_side,
                                           const Eigen::Vector3d& to_along, const Eigen::Vector3d& to_side) {
  return Eigen::Quaterniond(Eigen::Matrix3d(frame(to_along, to_side) * frame(from_along, from_side).transpose()))
      .normalized();
}

}  // namespace inhabit
