#pragma once
#include <torch/types.h>

#include "inhabit/inbetween/poses.h"
#include "inhabit/inbetween/scene_probe.h"

namespace inhabit::inbetween {

/// Where somebody went around what blocks the line from key to key: the path of the root, smoothed over a second so
/// that it does not tell of steps, at even speed over the ground. What the denoiser is trained to keep to, as it is to
/// keep to PathNet's paths in use.
/// @param truth (T) poses, all of them. @return (T, 2) as detours_of_poses
torch::Tensor walked_detours(const Poses& truth, const torch::Tensor& groups, const SceneDistances& scene);

}  // namespace inhabit::inbetween
