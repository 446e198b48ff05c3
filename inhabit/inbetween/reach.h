#pragma once
#include <torch/types.h>

#include <vector>

#include "inhabit/motion/clip.h"

namespace inhabit::inbetween {

/// Brings the joints that partial keys constrain to their targets.
/// - Root free: the body is translated by the residual of head, trunk, shoulders and hips, or by as much as hands and
///   feet are out of reach.
/// - Root constrained: the trunk leans until the hands reach, if nothing else of the trunk is constrained.
/// - Arms and legs follow wrists, ankles and feet by two-bone inverse kinematics. Elbows and knees come as near to
///   their targets as that allows.
/// The translation is interpolated from key to key; changes of limbs and trunk fade within half a second.
/// @param filled,given on the standard skeleton with rotations, of the same frames; `given` is read in key frames only.
/// @param keys in order; the first and the last are whole poses. @param groups (25) which feature groups the others
/// constrain (keyframes.h).
Clip reach_targets(const Clip& filled, const Clip& given, const std::vector<int64_t>& keys,
                   const torch::Tensor& groups);

}  // namespace inhabit::inbetween
