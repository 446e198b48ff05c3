#pragma once
#include <torch/types.h>

namespace inhabit {

// Rotations as tensors, batched over leading dimensions and differentiable (also at zero rotation).
// matrix (..., 3, 3); axis-angle (..., 3) radians; quaternion (..., 4) w x y z; 6D (..., 6): the first two columns of
// the matrix one after the other (Zhou et al. 2019).
// A wrong last dimension throws Error.

/// Rodrigues' formula.
torch::Tensor axis_angle_to_matrix(const torch::Tensor& axis_angle);
/// Angle in [0, pi].
torch::Tensor matrix_to_axis_angle(const torch::Tensor& matrix);
/// The quaternion need not be of unit length.
torch::Tensor quaternion_to_matrix(const torch::Tensor& quaternion);
/// Unit quaternion with w >= 0.
torch::Tensor matrix_to_quaternion(const torch::Tensor& matrix);
/// Gram-Schmidt of the two columns, which need not be orthonormal.
torch::Tensor rotation6d_to_matrix(const torch::Tensor& rotation6d);
/// The first two columns of matrices (..., 3, 3), as (..., 6).
torch::Tensor matrix_to_rotation6d(const torch::Tensor& matrix);
/// Rotation about the vertical +Y by yaw (...) radians, from +Z towards +X: (..., 3, 3).
torch::Tensor yaw_matrix(const torch::Tensor& yaw);
torch::Tensor yaw_matrix(double yaw);  ///< float32
/// Yaw (...) of somebody whose left is along `left` (..., 3): 0 facing +Z, pi/2 facing +X; 0 where `left` is vertical.
torch::Tensor yaw_of_left(const torch::Tensor& left);
/// Spherical interpolation between quaternions (..., 4) at u (...) in [0, 1], over the shorter arc.
torch::Tensor slerp(const torch::Tensor& from, const torch::Tensor& to, const torch::Tensor& u);

}  // namespace inhabit
