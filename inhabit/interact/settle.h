#pragma once
#include "inhabit/body/bones.h"
#include "inhabit/interact/state.h"

namespace inhabit::interact {

/// A posed frame on a person's bones.
struct SettledPose {
  std::vector<Eigen::Quaterniond> local;            ///< one unit quaternion a joint, relative to its parent
  Eigen::Vector3d trans = Eigen::Vector3d::Zero();  ///< metres, as Clip::trans
  BonesPose posed;                                  ///< places and rotations of it
};

/// Puts a predicted pose on the person's bones, and the state along with it: rotations as predicted, then legs and arms
/// bend until ankles and wrists are where they were predicted. Allocates nothing where `pose` has been used before.
void settle(const Bones& bones, State& state, SettledPose& pose);

}  // namespace inhabit::interact
