#pragma once
#include <Eigen/Geometry>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// A rotation about the vertical and a shift: p -> R_y(yaw) p + shift. Metres, radians; yaw rotates +Z towards +X.
struct GroundTransform {
  double yaw = 0;                                   ///< radians
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< metres

  /// What takes it back.
  GroundTransform inverse() const;
};

/// From the right of a body to its left, which tells its heading (yaw_of_left, heading_of_left): the line between the
/// hips and that between the shoulders, added. @param left_hip and so on: positions, (..., 3) tensors or vectors.
template <class Position>
Position right_to_left(const Position& left_hip, const Position& right_hip, const Position& left_shoulder,
                       const Position& right_shoulder) {
  return (left_hip - right_hip) + (left_shoulder - right_shoulder);
}

/// The yaw (radians) at which the person faces: 0 is +Z, pi/2 is +X. From the line between the hips and that between
/// the shoulders where the skeleton has such joints (standard names), else from the root's rotation. Throws Error where
/// it has neither.
double heading(const Clip& clip, int64_t frame);

/// The same for joints (..., 22, 3) of the standard skeleton: (...) radians. Differentiable.
torch::Tensor headings(const torch::Tensor& joints);

/// The transform that brings `frame` to the canonical frame: the root above the origin of the ground plane (heights
/// stay), facing +Z.
GroundTransform canonical_transform(const Clip& clip, int64_t frame = 0);

/// The clip moved as a whole: joints, root, hand targets and objects.
Clip transformed(const Clip& clip, const GroundTransform& by);

}  // namespace inhabit
