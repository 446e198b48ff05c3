#pragma once
#include <torch/types.h>

#include <vector>

#include "inhabit/motion/clip.h"

namespace inhabit::inbetween {

/// Brings the joints that partial keys give to their places: the body moves as a whole by what head, trunk, shoulders
/// and hips miss theirs by, or hands and feet by more than a limb reaches, unless the root is given: then the trunk
/// leans until hands reach, if nothing else of it is given. Arms and legs follow wrists, ankles and feet by two-bone
/// inverse kinematics. The body's move goes from key to key, a limb's and the trunk's fade within half a second. Elbows
/// and knees come as near as that leaves them.
/// @param filled,given on the standard skeleton with rotations, of the same frames; `given` is looked at in keys.
/// @param keys in order; the first and the last are whole. @param groups (25) what those between give (keyframes.h)
Clip reach_given(const Clip& filled, const Clip& given, const std::vector<int64_t>& keys, const torch::Tensor& groups);

}  // namespace inhabit::inbetween
