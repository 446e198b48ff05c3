#pragma once
#include <string>

#include "inhabit/io/npz.h"

namespace inhabit {

/// The array of joint positions of a file that is not inhabit's own: `joints`, or one of the names that networks and
/// data sets give it (keypoints, positions, poses_3d, joint_positions, joints3d, keypoints3d, pose_3d, xyz, motion,
/// pred..., in upper or lower case; the only array of an .npy). (T, J, 3), (S, T, J, 3) for several motions, or
/// flattened (T, 3J). What is no `joints` must have such a shape with 5 to 256 joints: rows of 3 to 14 numbers are a
/// cloud of points. Empty where there is none.
std::string joint_array_name(const Npz& npz);

/// The archive with that array, unflattened, as `joints`; as it is where there is none.
Npz with_joint_array(const Npz& npz);

}  // namespace inhabit
