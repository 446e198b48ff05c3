#pragma once
#include <cstdint>
#include <vector>

#include "inhabit/motion/clip.h"

namespace inhabit::inbetween {

// Interpolation, the baselines of scene-aware in-betweening. Both functions read frames `keys` of `clip` only (in
// order, with the first and the last frame, as from key_frames). They meet the keys' rotations and translations exactly
// and place joints by forward kinematics. Labels, contacts and objects between keys are unknown and left out. Both
// throw Error where the clip has no rotations or the keys are not such.

/// The root linearly, rotations by slerp over the shorter arc.
Clip interpolate_linear(const Clip& clip, const std::vector<int64_t>& keys);

/// Natural cubic splines through the keys: of the root, and of each joint's quaternion, whose sign is chosen nearest to
/// that of the key before, with the result normalised. Unlike squad this has continuous acceleration whatever the
/// distances between keys, and one construction serves places and rotations; unlike a spline of 6D rotations it cannot
/// vanish halfway, since neighbouring keys are never more than a right angle apart as unit vectors.
Clip interpolate_spline(const Clip& clip, const std::vector<int64_t>& keys);

}  // namespace inhabit::inbetween
