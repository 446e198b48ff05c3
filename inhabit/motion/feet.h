#pragma once
#include <cstdint>
#include <vector>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// Footskate cleanup. While the ball of a foot (10, 11) is low and slow it stands: there it is put to one
/// place, the frames before and after lead to it, and the leg follows by two-bone inverse kinematics. Feet that
/// glide as one make steps in turn. A foot that goes is lifted where it would drag along the floor, unless the other
/// one goes quicker, and none stays under the floor. Feet keep which way they point; a place out of the leg's reach is
/// come as near to as that allows.
/// @param clip on the standard skeleton with rotations; joints may lie off the posed skeleton, as a network's do, and
/// move as its joints do. @param fixed frames that stay as they are, in order: a foot that stands in one of them stands
/// there, in two of them moves from one place to the other. @param floor height of what feet stand on, metres.
/// @param near frames of noisy poses, whose feet are moved by `within` metres at most.
Clip clean_feet(const Clip& clip, const std::vector<int64_t>& fixed, double floor = 0,
                const std::vector<int64_t>& near = {}, double within = 0);

}  // namespace inhabit
