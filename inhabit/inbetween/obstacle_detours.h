#pragma once
#include <torch/types.h>

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "inhabit/inbetween/poses.h"
#include "inhabit/inbetween/scene_probe.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/query.h"

namespace inhabit::inbetween {

/// The floor plan around the first frame's root joint: (96, 96) squares of 0.1 m, axes along the person's left and
/// ahead; 1 occupied, -1 free. A square is occupied where the scene has something 0.2 to 1.7 m above the floor.
/// @param root (3) metres, the first frame's; @param yaw its heading, radians; @param height of the floor, metres.
torch::Tensor scene_floor(const SceneQuery& scene, const torch::Tensor& root, double yaw, double height = 0);

/// Detours of the root trajectory around obstacles, found by A* over the floor plan: offsets (T, 2) in metres along x
/// and z from the straight line between key frames, in the canonical frame of the first pose. An offset is zero in key
/// frames, and between two key frames where one of them does not constrain the root, where the straight line is free,
/// where there is no path or none that can be walked in the time, or outside the floor plan.
/// @param floor (96, 96) of scene_floor. @param root (T, 3) metres, read in key frames only. @param groups (T, 25)
/// which feature groups each key frame constrains (keyframes.h). @param unreached gets the key frames whose straight
/// line is blocked and that no way leads to in the time; may be null
torch::Tensor detours_around(const torch::Tensor& floor, const torch::Tensor& root, const torch::Tensor& groups,
                             std::vector<int64_t>* unreached = nullptr);

/// The same for the keys of a clip, in the world's axes, with the floor plan around its first frame.
/// @param clip read in key frames only. @param groups (T, 25), the first frame a whole key. @param floor metres, height
torch::Tensor detours_of_clip(const Clip& clip, const torch::Tensor& groups, const SceneQuery& scene, double floor,
                              std::vector<int64_t>* unreached = nullptr);

/// The same from the distances that a network of residual motion sees, in training and in use.
/// @param keys (T) poses, read in key frames only
torch::Tensor detours_of_poses(const Poses& keys, const torch::Tensor& groups, const SceneDistances& scene,
                               std::vector<int64_t>* unreached = nullptr);

/// Radians that somebody turns by to face along a detour instead of along the straight line, (T); nothing in key
/// frames, and within half a second of them part of it. @param straight (T) x, z metres of the root without detours.
/// @param keys frames that give the root, in order
std::vector<double> turns_along(const std::vector<Eigen::Vector2d>& straight, const torch::Tensor& detours,
                                const std::vector<int64_t>& keys);

/// Moves the interpolated baseline along the detours: root and joint positions of standardised features (B, 201, T) are
/// shifted by `detours` (B, T, 2), metres. @param mask (B, 201, T) 1 for constrained features, which stay. @param
/// deviation (201) of the standardisation.
torch::Tensor along_detours(const torch::Tensor& baseline, const torch::Tensor& detours, const torch::Tensor& mask,
                            const torch::Tensor& deviation);

}  // namespace inhabit::inbetween
