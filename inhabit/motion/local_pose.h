#pragma once
#include <torch/types.h>

#include "inhabit/motion/canonical.h"

namespace inhabit {

// A motion as poses without place and heading, and the root motion that carries them. Joints are the
// standard 22, +Y up; any leading dimensions; the heading is that of the lines between hips and between shoulders.

/// Joints (..., T, 22, 3) with the root at the origin, facing +Z in every frame: what the protocols of pose
/// anticipation score.
torch::Tensor local_poses(const torch::Tensor& joints);

/// The root motion (..., T, 4): step to this frame along x and z as seen from the heading of the frame before (metres),
/// rotation about the vertical since then (radians), and height (metres). Step and rotation of the first frame are 0.
torch::Tensor root_motion(const torch::Tensor& joints);

/// Joints in the world from local poses (..., T, 22, 3) and what root_motion gives (..., T, 4). Frame 0 takes its step
/// from `root` (..., 3) and `heading` (...).
torch::Tensor placed_poses(const torch::Tensor& poses, const torch::Tensor& motion, const torch::Tensor& root,
                           const torch::Tensor& heading);

/// The clip's poses on another person's bones: its rotations on `skeleton`, the root motion scaled with the length of
/// the legs. Needs rotations on the standard joints.
Clip on_skeleton(const Clip& clip, const Skeleton& skeleton);

}  // namespace inhabit
