#pragma once
#include <Eigen/Geometry>

#include "inhabit/body/bones.h"

namespace inhabit {

/// Where the middle and end joints of a two-bone chain go.
struct TwoBone {
  Eigen::Vector3d mid;    ///< metres, in the frame that the target is given in
  Eigen::Vector3d end;    ///< likewise; the target where the chain reaches it
  Eigen::Vector3d hinge;  ///< unit normal of the bending plane, pole x (end - start), about which bending is positive
};

/// Analytic two-bone inverse kinematics: law of cosines in the plane through start, target and pole.
/// Reach is clamped softly: up to (1 - softness) of the chain's length the end meets the target exactly; from there on
/// it approaches full length exponentially, so that a nearly straight limb neither locks nor snaps. A target nearer
/// than the bones allow is met as near as they do.
/// @param pole a world direction the middle joint bends towards (knee: forwards; elbow: backwards and down); it need
/// not be of unit length or orthogonal to the limb. @param softness fraction of the chain's length, 0 for a hard clamp.
TwoBone solve_two_bone(const Eigen::Vector3d& start, double upper_length, double lower_length,
                       const Eigen::Vector3d& target, const Eigen::Vector3d& pole, double softness = 0.01);

/// A leg or arm of the standard skeleton.
struct Limb {
  int start;                  ///< joint: hip or shoulder
  int mid;                    ///< joint: knee or elbow
  int end;                    ///< joint: ankle or wrist
  Eigen::Vector3d rest_pole;  ///< where the middle joint points at rest: +Z for knees, -Z for elbows
};
/// Which of a pair of limbs, as the person has it.
enum class Side { left, right };
/// Hip, knee and ankle among the standard joints; the knee points along +Z at rest.
Limb leg(Side side);
/// Shoulder, elbow and wrist among the standard joints; the elbow points along -Z at rest.
Limb arm(Side side);

/// What brings a limb to a target.
struct LimbPose {
  TwoBone joints;                     ///< where the middle and the end joint go, world
  Eigen::Quaterniond start_rotation;  ///< of the start joint, relative to its parent
  Eigen::Quaterniond mid_rotation;    ///< of the middle joint, relative to the start joint
  Eigen::Quaterniond start_global;    ///< of the start joint, to world
  Eigen::Quaterniond mid_global;      ///< of the middle joint, to world
};

/// Two-bone inverse kinematics of a limb. The middle joint rotates about its hinge only: the bones' rest directions and
/// the rest pole are carried onto the solved bones and the bending plane.
/// @param parent_rotation world rotation of the start joint's parent; @param start world position of the start joint.
LimbPose solve_limb(const Bones& bones, const Limb& limb, const Eigen::Quaterniond& parent_rotation,
                    const Eigen::Vector3d& start, const Eigen::Vector3d& target, const Eigen::Vector3d& pole,
                    double softness = 0.01);

/// Moves the end of a posed limb by `move`, as near as the limb reaches: its bones rotate by the least that does, what
/// hangs on the end keeps its orientation. @param local rotations that `pose` is of; changed.
void move_limb_end(const Bones& bones, const Limb& limb, const Eigen::Vector3d& move, const BonesPose& pose,
                   std::vector<Eigen::Quaterniond>& local);

}  // namespace inhabit
