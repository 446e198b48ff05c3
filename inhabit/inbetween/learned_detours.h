#pragma once
#include <torch/types.h>

#include <cstdint>
#include <vector>

#include "inhabit/inbetween/path_net.h"
#include "inhabit/inbetween/poses.h"
#include "inhabit/inbetween/scene_probe.h"

namespace inhabit::inbetween {

/// detours_of_poses (obstacle_detours.h) as PathNet has them. Of its paths one is drawn by how likely each is; one that
/// leads through something or cannot be walked in the time gives way to the likeliest that does neither. Where all do,
/// and where keys are over 7 m apart, the line stays straight.
/// @param temperature probabilities count to the power of 1 / temperature: at 0 the likeliest path is taken
/// @param seed what is drawn follows from. @param unreached gets the key frames whose straight line is blocked and that
/// no path leads to; may be null
torch::Tensor learned_detours(PathNet network, const Poses& keys, const torch::Tensor& groups,
                              const SceneDistances& scene, double temperature, uint64_t seed,
                              std::vector<int64_t>* unreached = nullptr);

}  // namespace inhabit::inbetween
