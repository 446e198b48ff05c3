#pragma once
#include <string>

#include "inhabit/io/npz.h"

namespace inhabit {

/// The array of joint positions of a file that is not inhabit's own: `joints`, or one of the names that networks and
/// data sets give it (keypoints, positions, poses_3d, joint_positions, joints3d, xyz, motion, pred..., the only array
/// of an .npy), in any case. (T, J, 3), (S, T, J, 3) for several motions, or, of names that say joints, flattened (T,
/// 3J). What is no `joints` must have such a shape with 5 to 256 joints: rows of 3 to 14 numbers are a cloud of points.
/// Empty where there is none.
std::string joint_array_name(const Npz& npz);

/// The array called `poses` or `pose` of a file that says nothing else of a body (betas, trans, root_orient) where it
/// holds the positions of SMPL's first 22 joints rather than their rotations: distances between neighbours stay alike
/// in it, and limbs are as long above as below. Empty where there is none.
std::string positions_called_poses(const Npz& npz);

/// The archive with that array, unflattened, as `joints`; as it is where there is none.
Npz with_joint_array(const Npz& npz);

}  // namespace inhabit
