#pragma once
#include <torch/types.h>

#include <cstdint>
#include <vector>

#include "inhabit/inbetween/config.h"
#include "inhabit/inbetween/pose_windows.h"
#include "inhabit/inbetween/residual.h"
#include "inhabit/inbetween/scene_probe.h"

namespace inhabit::inbetween {

/// B windows with keys drawn at random, as the denoiser of residual motion is trained on them.
struct ResidualBatch {
  ResidualFrames frames;   ///< the windows' baselines, and the scale of residuals
  torch::Tensor residual;  ///< (B, 135, T) true ones, divided by their scale, 0 where that is 0
  torch::Tensor open;      ///< (B, 135, T) 1 where the scale is not 0, else 0
  torch::Tensor fixed;     ///< (B, 244, T) of static_features
  torch::Tensor bones;     ///< (B, 21) metres, of bone_lengths
  torch::Tensor weights;   ///< (B, T, 22) of joints in their loss: 10 where a partial key has one, else 1
  torch::Tensor room;      ///< (B, T, 30) metres that the true body points keep from obstacles, their radius
                           ///< at most
  torch::Tensor kept;      ///< (B) 1, or 0 where the scene is hidden
  torch::Tensor steps;     ///< (B) int64 diffusion steps, 0 the cleanest
  torch::Tensor noise;     ///< (B, 135, T) normal, deviation 1; 0 where `open` is
  std::vector<SceneDistances> scenes;  ///< (B) also where the scene is hidden
  bool self_conditioned = false;       ///< the denoiser sees a prediction of its own, else zeros in its place

  ResidualBatch to(torch::Device device) const;  ///< the same on another device, scenes as they are
};

/// Windows drawn anew: `recorded` of them recorded motion, every second one mirrored, their keys far apart or as in the
/// paper, obstacles in the way of the baseline in `blocked` of them; it goes around in `way_around`, by a `walked` way
/// (walked_detours.h) or A*'s. @param table (61, 135), see residual_scale
ResidualBatch draw_batch(const PoseWindows& data, const Config& config, const torch::Tensor& table, size_t count,
                         uint64_t seed);

/// Every window twice, the second time after all others, with noise of its own.
ResidualBatch twice(const ResidualBatch& batch, uint64_t seed);

/// The table of a data set's residuals.
torch::Tensor residual_table(const PoseWindows& data, const Config& config, uint64_t seed);

}  // namespace inhabit::inbetween
