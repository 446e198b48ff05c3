#pragma once
#include <torch/types.h>

#include "inhabit/inbetween/baseline.h"
#include "inhabit/inbetween/residual.h"
#include "inhabit/inbetween/scene_probe.h"

namespace inhabit::inbetween {

// What the denoiser of residual motion sees in each frame: the noisy residual, the residual that it predicted at the
// step before (0 at the first), what stays the same at all steps, and the scene at the body as it is now predicted.

/// Numbers of one frame that stay the same: of the baseline 21 joints from the root, root height, velocities of root
/// and heading; distances from keys; targets of partial keys; the scene's fan; the level of noise on keys (0 in exact
/// frames).
inline constexpr int64_t kBaselineFeatures = 3 * (kStandardJoints - 1) + 5,  ///< of the baseline
    kTimingFeatures = 12,                                                    ///< distances from keys
    kTargetFeatures = 4 * kStandardJoints;                                   ///< targets of partial keys
/// All numbers of one frame that stay the same, 244.
inline constexpr int64_t kStaticFeatures = kBaselineFeatures + kTimingFeatures + kTargetFeatures + kFanFeatures + 1;
/// Channels of the denoiser.
inline constexpr int64_t kResidualChannels = 2 * kResidualFeatures + kStaticFeatures + kPointFeatures;
/// What is told of the person: the lengths of 21 bones.
inline constexpr int64_t kBoneFeatures = kStandardJoints - 1;

/// (244, T). @param fan (T, 75) of scene_fan; zeros hide the scene.
torch::Tensor static_features(const Baseline& baseline, const torch::Tensor& fan, double rate);

/// (B, 120, T): the scenes of B windows at the body as `predicted` (B, 135, T), divided residuals, has it.
torch::Tensor body_features(const ResidualFrames& frames, const std::vector<SceneDistances>& scenes,
                            const torch::Tensor& predicted);

/// The denoiser's input (B, 634, T), in training and in use. @param x noisy residual @param before the one predicted
/// at the step before @param fixed of static_features @param body of body_features; zeros hide the scene
torch::Tensor denoiser_channels(const torch::Tensor& x, const torch::Tensor& before, const torch::Tensor& fixed,
                                const torch::Tensor& body);

/// (21) metres.
torch::Tensor bone_lengths(const Poses& poses);

}  // namespace inhabit::inbetween
