#pragma once
#include <Eigen/Core>
#include <vector>

#include "inhabit/motion/clip.h"

namespace inhabit::interact {

/// A stay on a seat. Frames: sitting down goes from `down` to `first`, the pelvis is on the seat in [first, last], and
/// the person stands again at `risen`, having begun to rise at `rise`.
struct Stay {
  int64_t down = 0;                                ///< they begin to sit down
  int64_t first = 0;                               ///< first frame on the seat
  int64_t last = 0;                                ///< last frame on the seat
  int64_t rise = 0;                                ///< they begin to rise
  int64_t risen = 0;                               ///< they stand
  bool rises = false;                              ///< within the clip
  Eigen::Vector3d rest = Eigen::Vector3d::Zero();  ///< of the pelvis, world metres: the median while seated
  double heading = 0;                              ///< of the person, seated
};

/// The stays of a clip, in order: where the pelvis touches the scene (Clip::contact) for half a second or longer,
/// interruptions of under a second at the same place left out. Actions of the names sit_down and stand_up tell when
/// sitting down and rising begin and end; without them the height of the pelvis does. Empty where contacts are unknown.
std::vector<Stay> stays_of(const Clip& clip);

}  // namespace inhabit::interact
