#pragma once
#include <string>
#include <vector>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// Where a motion comes from: what tells a reader of files right are its options, what a stream takes is said as it is.
enum class MotionSource { file, stream };

/// What cannot be true of a person's motion, a line each that is_doubt() knows, with the option that tells it right:
/// legs that are under 0.2 or over 1.5 m long, under 0.66 m from the ankles over the pelvis to the base of the skull (a
/// child of 0.9 m has 0.71), a body that is upside down or lies in nearly all frames, a root that is faster than 12 m/s
/// in a tenth of the frames or more. Of skeletons without legs that find_landmarks knows, the speed alone.
std::vector<std::string> implausible(const Clip& clip, MotionSource source = MotionSource::file);

/// Whether a note, which may begin with the name of a file, is of implausible().
bool is_doubt(const std::string& note);

}  // namespace inhabit
