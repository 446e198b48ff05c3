#pragma once
#include <torch/types.h>

#include <cstdint>
#include <vector>

#include "inhabit/inbetween/path_net.h"
#include "inhabit/inbetween/poses.h"
#include "inhabit/inbetween/scene_probe.h"

namespace inhabit::inbetween {

/// Where somebody went around what blocks the line from key to key: the path of the root, smoothed over a second so
/// that it does not tell of steps, at even speed over the ground. What the denoiser is trained to keep to, as it is to
/// keep to PathNet's paths in use.
/// @param truth (T) poses, all of them. @return (T, 2) as detours_of_poses
torch::Tensor walked_detours(const Poses& truth, const torch::Tensor& groups, const SceneDistances& scene);

/// detours_of_poses (obstacle_detours.h) as PathNet has them. Of its paths one is drawn by how likely each is; one that
/// leads through something or cannot be walked in the time gives way to the likeliest that does neither. Where all do,
/// and where keys are over 7 m apart, the line stays straight.
/// @param seed what is drawn follows from. @param unreached gets the key frames whose straight line is blocked and that
/// no path leads to; may be null
torch::Tensor learned_detours(PathNet network, const Poses& keys, const torch::Tensor& groups,
                              const SceneDistances& scene, uint64_t seed, std::vector<int64_t>* unreached = nullptr);

}  // namespace inhabit::inbetween
