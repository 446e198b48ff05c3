#pragma once
#include <torch/types.h>

#include <vector>

#include "inhabit/inbetween/baseline.h"

namespace inhabit::inbetween {

// Residual motion: what a window's motion does beyond the interpolated baseline of its keys, told in the heading frame
// of the baseline at each frame. 135 numbers: [0, 3) the root's displacement in metres, along the detour where the
// baseline has one (detour_legs.h), then of each joint the first two columns of its rotation in the world relative to
// the baseline's, less those of the identity; along a detour, relative to the baseline's rotated with its bend. Neither
// the scene's axes nor the frames that a skeleton has at rest change these numbers. They are divided by their deviation
// at that distance from the keys, which is 0 in key frames.

/// Numbers of residual motion in a frame, 135.
inline constexpr int64_t kResidualFeatures = 3 + 6 * kStandardJoints;
/// Rows of a scale: deviations of bridge() = 0, 1, ... 60 frames and more.
inline constexpr int64_t kScaleRows = 61;

/// Of a motion and its baseline, (135, T), not divided.
torch::Tensor residual_of(const Poses& motion, const Baseline& baseline);

/// What divides them (135, T): rows of `table` (61, 135), interpolated; the root's by its own keys; and what noise of
/// keys adds. 0 behind the last key, where nothing is asked for.
torch::Tensor residual_scale(const Baseline& baseline, const torch::Tensor& table);

/// Deviations by distance from keys, from residuals that come window by window.
class ResidualStatistics {
 public:
  /// @param residual (135, T) of residual_of, not divided; what lies behind the last whole key does not count.
  void add(const torch::Tensor& residual, const Baseline& baseline);
  /// (61, 135), smoothed, growing with the distance.
  torch::Tensor table() const;

 private:
  torch::Tensor squares_ = torch::zeros({kScaleRows, kResidualFeatures}, torch::kFloat64);
  torch::Tensor counts_ = torch::zeros({kScaleRows, 2}, torch::kFloat64);  // of rotations, of the root
};

/// The baselines of B windows as tensors, to pose residuals on.
struct ResidualFrames {
  torch::Tensor root;      ///< (B, T, 3) the baseline's, world
  torch::Tensor bones;     ///< (B, T, 22, 3) from the parent to each joint, heading frame; 0 for the root
  torch::Tensor ends;      ///< (B, T, 8, 3) from its joint to each of limb_ends(), heading frame
  torch::Tensor rotation;  ///< (B, T, 3, 3) heading frame to world
  torch::Tensor scale;     ///< (B, 135, T) of residual_scale
  DetourFrames detours;    ///< where the baselines go around obstacles

  ResidualFrames to(torch::Device device) const;  ///< the same on another device
};
/// The tensors of B baselines of one length.
/// @param table (61, 135) deviations by distance from keys, ResidualStatistics::table
ResidualFrames residual_frames(const std::vector<const Baseline*>& baselines, const torch::Tensor& table);

/// Rotations (B, T, 22, 3, 3) relative to the baseline's, heading frame, of residuals (B, 135, T) that were divided.
torch::Tensor residual_rotations(const ResidualFrames& frames, const torch::Tensor& residual);
/// Joints (B, T, 22, 3) relative to the baseline's root, heading frame. Differentiable.
torch::Tensor residual_joints(const ResidualFrames& frames, const torch::Tensor& residual);
/// Points that the penetration loss keeps out of obstacles, (B, T, 38, 3) likewise: the body points, then the limb
/// ends, of residuals and what residual_joints() makes of them. Differentiable.
torch::Tensor guarded_points(const ResidualFrames& frames, const torch::Tensor& residual, const torch::Tensor& joints);
/// Points (B, T, N, 3) relative to the baseline's root, heading frame, in the world.
torch::Tensor to_world(const ResidualFrames& frames, const torch::Tensor& points);

/// The motion that one window's residual (135, T), divided by `scale` (135, T), says.
Poses motion_of(const torch::Tensor& residual, const torch::Tensor& scale, const Baseline& baseline);

}  // namespace inhabit::inbetween
