#pragma once
#include <torch/types.h>

#include "inhabit/body/body_model.h"
#include "inhabit/body/skeleton.h"

namespace inhabit {

/// Global transforms of a posed skeleton.
struct Pose {
  torch::Tensor positions;  ///< (..., J, 3) metres
  torch::Tensor rotations;  ///< (..., J, 3, 3) joint frame to world
};

/// Forward kinematics, batched and differentiable.
/// global R_j = R_parent(j) R_j,  p_j = p_parent(j) + R_parent(j) offset_j,  p_root = trans + offset_root.
/// @param rotations (..., J, 3, 3) local rotation matrices; @param trans (..., 3) metres.
/// @param offsets (J, 3) or (..., J, 3) metres.
Pose forward_kinematics(const std::vector<int>& parents, const torch::Tensor& offsets, const torch::Tensor& rotations,
                        const torch::Tensor& trans);

/// Joint positions (T, J, 3) of axis-angle rotations (T, J, 3) and trans (T, 3) on a skeleton.
/// @param translations (T, J, 3) in place of the skeleton's offsets where joints translate (Clip::translations), or
/// undefined.
torch::Tensor joint_positions(const Skeleton& skeleton, const torch::Tensor& rotations, const torch::Tensor& trans,
                              const torch::Tensor& translations = {});

/// Skin vertices (..., V, 3) of a posed body (linear blend skinning, with shape and, where the model has them, pose
/// blend shapes). Differentiable in every argument.
/// @param betas (B') or undefined; @param rotations (..., J, 3, 3) local; @param trans (..., 3).
torch::Tensor skin(const BodyModel& model, const torch::Tensor& betas, const torch::Tensor& rotations,
                   const torch::Tensor& trans);

}  // namespace inhabit
