#pragma once
#include <Eigen/Core>
#include <array>

#include "inhabit/body/skeleton.h"

namespace inhabit {

/// Shape parameters of the built-in body; the unit of each is one standard deviation of adults.
enum BuiltinBeta {
  kStature,    ///< everything scales, 4 % a unit
  kLegs,       ///< thighs and shanks longer, 4 % a unit
  kArms,       ///< upper arms and forearms longer, 4 % a unit
  kTorso,      ///< spine longer, 4 % a unit
  kGirth,      ///< flesh thicker around the bones, 10 % a unit (fat and muscle together)
  kShoulders,  ///< shoulders wider, 4.5 % a unit
  kHips,       ///< hips wider, 6 % a unit
  kBelly,      ///< waist deeper and wider in front, about 2.5 cm a unit
  kBuiltinBetas
};

/// Joints of the built-in body at rest, metres from the pelvis joint. A T-pose: arms along +-X, feet along +Z.
/// Segment lengths are fractions of stature after Drillis and Contini (1966), as given by Winter, "Biomechanics and
/// Motor Control of Human Movement", figure 4.1; docs/body.md lists them and where a joint centre differs from the
/// landmark.
std::array<Eigen::Vector3d, kStandardJoints> builtin_rest_joints();

/// How each joint moves with one unit of `beta`, metres.
std::array<Eigen::Vector3d, kStandardJoints> builtin_joint_direction(BuiltinBeta beta);

/// Height of the built-in body's pelvis joint above the soles at rest, and of the top of its head, metres.
inline constexpr double kBuiltinPelvisHeight = 0.955,  ///< of the pelvis joint
    kBuiltinStature = 1.72;                            ///< of the top of the head

}  // namespace inhabit
