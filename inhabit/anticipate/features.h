#pragma once
#include <torch/types.h>

#include "inhabit/anticipate/network.h"
#include "inhabit/nn/feature_scale.h"

namespace inhabit::anticipate {

/// What the networks see of joints (..., T, 22, 3): (..., T, F) local poses without the root, then the root motion
/// (motion/local_pose.h), in metres and radians.
torch::Tensor joint_features(const torch::Tensor& joints);

/// The same of the motion seen in a mirror: left is right.
torch::Tensor mirrored_features(const torch::Tensor& features);

/// Local poses (..., T, 22, 3) of features (..., T, F), root at the origin.
torch::Tensor feature_poses(const torch::Tensor& features);

/// Joints in the world (..., T, 22, 3) of features that follow on a frame with the root at `root` (..., 3) and
/// `heading` (...).
torch::Tensor feature_joints(const torch::Tensor& features, const torch::Tensor& root, const torch::Tensor& heading);

/// The scale of features (N, F). Deviations under 5 cm count as 5 cm: joints that hardly move must not count like those
/// that do.
FeatureScale feature_scale(const torch::Tensor& features);

}  // namespace inhabit::anticipate
