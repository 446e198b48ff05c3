#pragma once
#include "inhabit/motion/clip.h"
#include "inhabit/reconstruct/camera.h"

namespace inhabit::reconstruct {

/// The motion in the world that results are in: rotated upright, or out of each frame's camera. Annotations of the
/// scene it came with are left out. Throws Error(subject, ...) for a motion without rotations, and where the camera has
/// poses for another number of frames.
Clip in_world(const Clip& motion, const Camera& camera, const std::string& subject);

/// The motion with its root moved by `moved` (keys) metres at frames `keys`, linearly in between.
Clip with_roots_moved(const Clip& motion, const std::vector<int64_t>& keys, const std::vector<Eigen::Vector3d>& moved);

}  // namespace inhabit::reconstruct
