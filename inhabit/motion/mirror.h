#pragma once
#include "inhabit/motion/clip.h"

namespace inhabit {

/// The image of a clip of the standard skeleton in the plane x = 0: left and right change places.
Clip mirrored(const Clip& clip);

}  // namespace inhabit
