#pragma once
#include <Eigen/Geometry>
#include <array>

#include "inhabit/synth/figure.h"

namespace inhabit {

/// Where a foot is. The foot joint (ball of the foot) is what is placed; the ankle follows from yaw and pitch.
struct FootControl {
  Eigen::Vector3d ball = Eigen::Vector3d::Zero();  ///< foot joint, world metres
  double yaw = 0;                                  ///< heading of the foot, radians from +Z towards +X
  double pitch = 0;                                ///< of the sole, radians, toes up positive
  double toe_pitch = 0;                            ///< of the toes against the floor
  Eigen::Vector3d knee = Eigen::Vector3d::Zero();  ///< where the knee goes, as far as the leg's length lets it,
  double knee_weight = 0;                          ///< and how much that counts, 0 to 1
};

/// A hand drawn towards a place, with `weight` from 0 (hanging freely) to 1 (pinned).
struct HandPull {
  double weight = 0;                                ///< 0 to 1
  int anchor = -1;                                  ///< joint in whose frame the following two are; -1: world
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< wrist joint
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< wrist's global rotation
  double swivel = 0;                                             ///< elbow outwards (radians) from hanging down
  double rise = 0;                                               ///< metres the wrist is higher on its path
};

/// The wrist's global rotation when the hand points along `ahead` with the palm facing `palm` (unit, orthogonal).
Eigen::Quaterniond hand_rotation(int side, const Eigen::Vector3d& ahead, const Eigen::Vector3d& palm);

/// A free arm, angles in radians, 0 hanging straight.
struct ArmControl {
  double flexion = 0;            ///< forwards
  double abduction = 0;          ///< off the body
  double twist = 0;              ///< about the upper arm
  double elbow = 0;              ///< bent
  std::array<HandPull, 3> pull;  ///< each laid over those before it
};

/// Everything that decides one frame's pose.
struct Controls {
  Eigen::Vector3d root = Eigen::Vector3d::Zero();  ///< world position of the root joint
  double yaw = 0;                                  ///< of the pelvis: heading, radians from +Z towards +X
  double tilt = 0;                                 ///< of the pelvis: forward lean, radians
  double list = 0;                                 ///< of the pelvis: left side down, radians
  double bend = 0;                                 ///< of the thorax against the pelvis: forward, radians
  double lean = 0;                                 ///< of the thorax against the pelvis: to the left, radians
  double twist = 0;                                ///< of the thorax against the pelvis: turned left, radians
  double gaze_yaw = 0;                             ///< of the head in the world, radians
  double gaze_pitch = 0;                           ///< of the head in the world, radians, down positive
  std::array<FootControl, 2> foot;                 ///< left, right
  std::array<ArmControl, 2> arm;                   ///< left, right
};

/// A posed figure: local and global rotations, world joint positions.
struct Posed {
  std::array<Eigen::Quaterniond, kStandardJoints> local;   ///< relative to the parent
  std::array<Eigen::Quaterniond, kStandardJoints> global;  ///< to world
  std::array<Eigen::Vector3d, kStandardJoints> position;   ///< metres
};

/// Poses the figure: trunk from angles, legs and pulled arms by two-bone inverse kinematics.
Posed pose_figure(const Figure& figure, const Controls& controls);

/// Where the ankle of `foot` (0 left, 1 right) is.
Eigen::Vector3d ankle_position(const Figure& figure, int side, const FootControl& foot);
/// Where the hip of `side` is.
Eigen::Vector3d hip_position(const Figure& figure, int side, const Controls& controls);

}  // namespace inhabit
