#pragma once
#include "inhabit/motion/clip.h"

namespace inhabit {

/// Turns a clip of a z-up world to +Y up, by -90 degrees about x: (x, y, z) -> (x, z, -y), with all that is annotated.
void turn_upright(Clip& clip);

}  // namespace inhabit
