#pragma once
#include <torch/types.h>

#include "inhabit/scene/query.h"

namespace inhabit::inbetween {

/// Where nobody can walk: (96, 96) 1 or -1 of 0.1 m squares, along the person's left and ahead, about the root joint of
/// the first frame. Occupied is what has something from 0.2 to 1.7 m above the floor.
/// @param root (3) metres; @param yaw radians that it faces; @param height metres, the floor's.
torch::Tensor scene_floor(const SceneQuery& scene, const torch::Tensor& root, double yaw, double height = 0);

/// How far the root is to leave the straight lines between its given places so that it goes around what stands in them,
/// by A* over the floor: (T, 2) metres along x and z; zero in key frames, between two of which one does not give the
/// root, where the straight way is free, where there is no other, and beyond the floor known. In the canonical frame of
/// the first pose.
/// @param floor (96, 96) of scene_floor. @param root (T, 3) metres, looked at in key frames. @param groups (T, 25) what
/// key frames give (keyframes.h).
torch::Tensor detours_around(const torch::Tensor& floor, const torch::Tensor& root, const torch::Tensor& groups);

/// Standardised features (B, 201, T) between the given ones moved by `ways` (B, T, 2): root and joints.
/// @param mask (B, 201, T) 1 for given features, which stay. @param deviation (201)
torch::Tensor along_detours(const torch::Tensor& between, const torch::Tensor& ways, const torch::Tensor& mask,
                            const torch::Tensor& deviation);

}  // namespace inhabit::inbetween
