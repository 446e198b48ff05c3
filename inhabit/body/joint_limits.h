#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "inhabit/body/body_model.h"

namespace inhabit {

/// How far each joint of a body can rotate: lowest and highest of the axis-angle components of its local rotation,
/// radians.
struct JointLimits {
  std::vector<Eigen::Vector3d> low;   ///< a joint each
  std::vector<Eigen::Vector3d> high;  ///< a joint each, not below `low`

  /// What is beyond, component by component, signed; zero within the limits.
  Eigen::Vector3d beyond(size_t joint, const Eigen::Vector3d& axis_angle) const {
    return (axis_angle - high[joint]).cwiseMax(0.0) + (axis_angle - low[joint]).cwiseMin(0.0);
  }
};

/// Those of a body, or of its first `most` joints; more than a whole revolution where it has none.
JointLimits joint_limits(const BodyModel& model, int64_t most = INT64_MAX);

}  // namespace inhabit
