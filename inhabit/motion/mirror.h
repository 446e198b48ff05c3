#pragma once
#include "inhabit/motion/clip.h"

namespace inhabit {

/// Index (22) of the joint on the other side, of every joint of the standard skeleton.
const torch::Tensor& other_sides();

/// The image of standard joints (..., 22, 3) in the plane x = 0: left and right change places.
torch::Tensor mirrored_joints(const torch::Tensor& joints);

/// The image of points (..., 3), or what else has its first number change sign.
torch::Tensor mirrored_points(const torch::Tensor& points);

/// The image of a clip of the standard skeleton in the plane x = 0: left and right change places.
Clip mirrored(const Clip& clip);

}  // namespace inhabit
