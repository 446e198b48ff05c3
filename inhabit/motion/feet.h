#pragma once
#include <cstdint>
#include <vector>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// Footskate cleanup.
/// - A foot is in contact while its ball (joints 10, 11) is low and slow. During a contact it stays at one foothold;
///   the frames before and after blend to it.
/// - Where both feet glide at once, alternating steps replace the glide.
/// - A foot that drags along the floor is lifted, unless the other foot is faster. No foot stays below the floor.
/// - The legs follow by two-bone inverse kinematics. Feet keep their orientation. A foothold out of reach is approached
///   as far as the leg allows.
/// @param clip on the standard skeleton with rotations. Its joints may differ from the posed skeleton, as a network's
/// do; they move with it. @param fixed frames that stay unchanged, in order. A contact that includes one such frame
/// takes its foothold there; one that includes two moves from the first foothold to the second. @param floor height
/// that feet stand at, metres. @param near frames with noisy poses, whose feet are moved by at most `within` metres.
Clip clean_feet(const Clip& clip, const std::vector<int64_t>& fixed, double floor = 0,
                const std::vector<int64_t>& near = {}, double within = 0);

}  // namespace inhabit
