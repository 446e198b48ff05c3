#pragma once
#include <Eigen/Geometry>
#include <vector>

#include "inhabit/body/skeleton.h"

namespace inhabit {

/// A skeleton as plain numbers in double precision, for code that works one frame at a time. Metres.
struct Bones {
  std::vector<int> parents;  ///< of each joint, earlier ones; -1 for joint 0, the root
  std::vector<Eigen::Vector3d>
      offsets;  ///< rest position relative to the parent; the root's own rest position for joint 0

  /// Number of joints.
  int size() const { return static_cast<int>(parents.size()); }
};

/// Position and rotation of every joint (joint frame to world).
struct BonesPose {
  std::vector<Eigen::Vector3d> positions;     ///< metres, world
  std::vector<Eigen::Quaterniond> rotations;  ///< unit
};

/// A skeleton's tree in double precision: parents, and offsets in metres from each joint's parent.
Bones bones_of(const Skeleton& skeleton);

/// Forward kinematics of one frame, the formula of kinematics.h. `out` is resized; nothing is allocated when it already
/// has the right size.
/// @param local one unit quaternion a joint, relative to its parent.
void pose_bones(const Bones& bones, const std::vector<Eigen::Quaterniond>& local, const Eigen::Vector3d& trans,
                BonesPose& out);

/// One frame of local rotations as quaternions, from axis-angle (J, 3) radians.
std::vector<Eigen::Quaterniond> local_quaternions(const torch::Tensor& axis_angle);

}  // namespace inhabit
