#pragma once
#include <Eigen/Core>

namespace inhabit {

/// The middle of a palm's skin, which touches, in the frame of its wrist, metres. `side` 0 left, 1 right.
Eigen::Vector3f palm_offset(int side);

}  // namespace inhabit
