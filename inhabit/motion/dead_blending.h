#pragma once
#include "inhabit/motion/pose_track.h"

namespace inhabit {

/// Lets one motion go over into another without a jump by dead blending: the first is carried on at the velocity of its
/// end, which halves every 3 frames (so that it goes on by five frames' worth in all), and faded into the second. What
/// the second does in its first few frames counts little.
/// @param track frame 0 is the last of the first motion, the others are of the second; those from frame 1 on are
/// changed, but for `places`
/// @param before of the same joints and rate; ends with the first motion's last frame but one
/// @param frames of the fade, at least 1
void dead_blend(PoseTrack& track, const PoseTrack& before, int64_t frames);

}  // namespace inhabit
