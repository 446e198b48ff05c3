#pragma once
#include "inhabit/motion/clip.h"
#include "inhabit/scene/free_space.h"

namespace inhabit {

/// The same steps around what stands on the floor: the motion is rotated about the vertical as it goes, so that the
/// root keeps some 0.35 m from obstacles where it can. Every fifth of a second the rotation rate is chosen, of those up
/// to 200 degrees a second, whose path over the next two seconds goes through nothing for the longest, then is the
/// clearest, then the straightest. Who does not walk, or is not near anything, moves as before; who starts among
/// obstacles, at a table or on a chair, goes no nearer to them than they were.
/// @param floor in the clip's axes; the floor's end may be an obstacle too (free_floor)
Clip steered(const Clip& clip, const FreeSpace& floor);

}  // namespace inhabit
