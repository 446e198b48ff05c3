#pragma once
#include <torch/types.h>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// How fast and how smoothly a body moves, means over frames (and joints).
struct Dynamics {
  int64_t frames = 0;       ///< how many went into the means
  double speed = 0;         ///< of the root over the ground, m/s
  double acceleration = 0;  ///< of the joints, m/s^2: length of the second difference times rate^2
  double jerk = 0;          ///< of the joints, m/s^3: length of the third difference times rate^3
};

/// Over the frames t for which frames t to t+3 all are in `mask` (T) bool; the whole clip where it is undefined.
Dynamics dynamics(const Clip& clip, const torch::Tensor& mask = {});

/// (T) bool: frames whose action is called `name`; none where the clip has no such action.
torch::Tensor frames_of_action(const Clip& clip, const std::string& name);

}  // namespace inhabit
