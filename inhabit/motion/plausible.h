#pragma once
#include <string>
#include <vector>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// What cannot be true of a person's motion, a line each, with the option that tells it right: legs that are under 0.2
/// or over 1.5 m long, a body that is upside down or lies in nearly all frames, a root that is faster
/// than 12 m/s in a tenth of the frames or more. Of skeletons without legs that find_landmarks knows, the speed alone.
std::vector<std::string> implausible(const Clip& clip);

}  // namespace inhabit
