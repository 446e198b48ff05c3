#pragma once
#include "inhabit/motion/clip.h"

namespace inhabit {

/// Height of the floor under a person's poses, metres: that of the balls of the feet (joints left_foot and right_foot)
/// where they are slow, less what they stand above the sole. In under a second of frames the lowest ball tells, for key
/// poses have no speed, and on a skeleton without such joints the lowest joint. The floor of a scene: scene/floor.h.
double floor_under(const Clip& poses);

}  // namespace inhabit
