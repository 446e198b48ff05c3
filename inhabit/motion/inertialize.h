#pragma once
#include "inhabit/motion/pose_track.h"

namespace inhabit {

/// Lets one motion go over into another without a jump (inertialization, as in game animation: what the two differ by
/// where they meet fades out, so that only the second has to be known beyond that).
/// @param track frame 0 is the last of the first motion, the others are of the second; those from frame 1 on are
/// changed
/// @param before the first motion's last frame but one; of the two its velocity is taken, for frame 1
/// @param frames in which the difference fades out, at least 1
void inertialize(PoseTrack& track, const PoseTrack& before, int64_t frames);

}  // namespace inhabit
