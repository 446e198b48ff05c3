#pragma once
#include "inhabit/motion/clip.h"

namespace inhabit {

/// How often feet slide over the floor.
struct FootSkating {
  int64_t frames = 0;   ///< frames that have a next one
  int64_t skating = 0;  ///< of these, with a foot joint that slides
  /// Of the frames; 0 where there is none.
  double fraction() const { return frames > 0 ? static_cast<double>(skating) / static_cast<double>(frames) : 0; }
};

/// Frames in which a foot joint (ankles 7, 8 and balls 10, 11 of the standard skeleton) is less than `height` metres
/// above the floor y = 0 and moves more than `distance` metres by the next frame.
FootSkating foot_skating(const Clip& clip, double height = 0.05, double distance = 0.025);

}  // namespace inhabit
