#pragma once
#include <Eigen/Geometry>
#include <array>

#include "inhabit/body/body_model.h"
#include "inhabit/body/bones.h"
#include "inhabit/body/joint_limits.h"

namespace inhabit {

/// A body of one shape, measured once so that frames can be posed without tensors. Metres, radians. Sides: 0 left, 1
/// right.
struct Figure {
  Bones bones;              ///< the standard joints
  JointLimits limits;       ///< of these
  double thigh = 0;         ///< length
  double shank = 0;         ///< length
  double upper_arm = 0;     ///< length
  double forearm = 0;       ///< length
  double stand_height = 0;  ///< root above the soles at rest
  double ankle_ahead = 0;   ///< ankles ahead of the root at rest
  double ball_height = 0;   ///< foot joint above the sole
  double heel_back = 0;     ///< from foot joint back to the end of the heel
  double toe_front = 0;     ///< from foot joint ahead to the tip of the toes
  double seat_depth = 0;    ///< root above what one sits on
  double back_depth = 0;    ///< root to the back of the pelvis
  double thigh_depth = 0;   ///< radius of the thigh
  double palm_depth = 0;    ///< wrist above what a flat hand lies on
  double palm_reach = 0;    ///< wrist to the middle of the palm, along the hand

  /// Length of a straight leg, hip to ankle.
  double leg() const { return thigh + shank; }
  /// Length of a straight arm, shoulder to wrist.
  double arm() const { return upper_arm + forearm; }
};

/// Measures `model` with shape `betas` (B') or undefined.
Figure make_figure(const BodyModel& model, const torch::Tensor& betas);

}  // namespace inhabit
