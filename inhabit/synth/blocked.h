#pragma once
#include <string>

#include "inhabit/data/native.h"

namespace inhabit {

/// Which windows and keys are looked at.
struct BlockedOptions {
  int64_t frames = 121;  ///< of a window
  int64_t every = 60;    ///< frames between keys
  int64_t stride = 60;   ///< frames between the starts of windows
  int64_t clips = 0;     ///< at most so many, evenly spread; 0: all
};

/// In how many windows the room decides how one gets from key to key.
struct BlockedWindows {
  int64_t clips = 0;      ///< that were looked at
  int64_t windows = 0;    ///< of these
  int64_t colliding = 0;  ///< windows in which the motion itself collides in some frame
  int64_t blocked = 0;    ///< windows in which it does not, but the straight path between its keys does
  double straight = 0;    ///< fraction of frames in which the body on the straight path collides
  double real = 0;        ///< and the body on its own path
};

/// Measures windows of the clips of `split` ("train", "val", "test" or "all") that have a scene. Between keys the root
/// of the straight path moves linearly and rotations by slerp; what collides is the skin, by CollisionMeter. Throws
/// Error where an option is out of range.
BlockedWindows blocked_windows(const Dataset& dataset, const std::string& split, const BlockedOptions& options = {});

}  // namespace inhabit
