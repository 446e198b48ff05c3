#pragma once
#include <vector>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// Height of the floor under a person's poses, metres: that of the balls of the feet (joints left_foot and right_foot)
/// where they are slow, less what they stand above the sole. In under a second of frames the lowest ball tells, for key
/// poses have no speed, and on a skeleton without such joints the lowest joint. The floor of a scene: scene/floor.h.
double floor_under(const Clip& poses);

/// The same from heights alone, for motion whose speeds tell nothing yet: a noisy recording, a network's output. The
/// frame that a twentieth of the others are lower than tells.
/// @param lower_balls metres, height of the lower ball of the feet in each frame; not empty
double floor_under_lowest(std::vector<double> lower_balls);

}  // namespace inhabit
