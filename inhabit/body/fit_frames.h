#pragma once
#include <torch/types.h>

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "inhabit/body/bones.h"

// What both fits of rotations to joints have in common (fit.h).

namespace inhabit {

/// Where the standard joints of one frame should be, metres.
using FitTargets = std::array<Eigen::Vector3d, kStandardJoints>;

/// One frame of a body's first 22 joints.
struct FitFrame {
  std::array<Eigen::Quaterniond, kStandardJoints> local;  ///< relative to the parent
  Eigen::Vector3d trans;                                  ///< metres, as Clip::trans
};

/// Joints (T, 22 or more, 3). Throws Error on wrong shapes and numbers that are not finite.
std::vector<FitTargets> fit_targets(const torch::Tensor& joints);

/// The first 22 joints of a body's skeleton. Throws Error when they are not the standard ones.
Bones fit_bones(const Skeleton& skeleton);

/// Every frame in closed form, as fit_rotations() says.
std::vector<FitFrame> fit_frames(const Bones& bones, const std::vector<FitTargets>& targets);

}  // namespace inhabit
