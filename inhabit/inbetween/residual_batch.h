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
  torch::Tensor room;      ///< (B, T, 38) metres that the true guarded_points keep from obstacles, their radius
                           ///< at most
  torch::Tensor passes;    ///< (B, T, 3) of passing_distance
  torch::Tensor feet;      ///< (B, T, 4) of foot_contacts
  torch::Tensor kept;      ///< (B) 1, or 0 where the scene is hidden
  torch::Tensor steps;     ///< (B) int64 diffusion steps, 0 the cleanest
  torch::Tensor noise;     ///< (B, 135, T) normal, deviation 1; 0 where `open` is
  std::vector<SceneDistances> scenes;  ///< (B) also where the scene is hidden
  bool self_conditioned = false;       ///< the denoiser sees a prediction of its own, else zeros in its place

  ResidualBatch to(torch::Device device) const;  ///< the same on another device, scenes as they are
};

/// `count` windows drawn anew. Half of them are mirrored. Keys are drawn far apart or as in the paper. Fractions of the
/// windows, of config.training:
/// - `recorded` are recorded motion, the others generated;
/// - `blocked` have a baseline that goes through obstacles, where such a window is found; their keys are far apart;
/// - `way_around` have a baseline with detours. `walked` of these take the detour that was walked (walked_detours.h),
///   the others that of A*.
///
/// @param table (61, 135), see residual_scale
ResidualBatch draw_batch(const PoseWindows& data, const Config& config, const torch::Tensor& table, size_t count,
                         uint64_t seed);

/// Metres that the true root_column keeps from obstacles (B, T, 3), 0.4 at most: the least of half a second before and
/// after each frame, as a sample may pass them sooner or later. @param root (B, T, 3) metres, world
torch::Tensor passing_distance(const std::vector<SceneDistances>& scenes, const torch::Tensor& root);

/// Every window twice, the second time after all others, with noise of its own.
ResidualBatch twice(const ResidualBatch& batch, uint64_t seed);

/// The table of a data set's residuals.
torch::Tensor residual_table(const PoseWindows& data, const Config& config, uint64_t seed);

}  // namespace inhabit::inbetween
