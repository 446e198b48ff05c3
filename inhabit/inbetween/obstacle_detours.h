#pragma once
#include <torch/types.h>

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "inhabit/inbetween/poses.h"
#include "inhabit/inbetween/scene_probe.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/query.h"
#include "inhabit/scene/walk_path.h"

namespace inhabit::inbetween {

/// The floor plan around the first frame's root joint: (96, 96) squares of 0.1 m, axes along the person's left and
/// ahead; 1 occupied, -1 free. A square is occupied where the scene has something 0.2 to 1.7 m above the floor.
/// @param root (3) metres, the first frame's; @param yaw its heading, radians; @param height of the floor, metres.
torch::Tensor scene_floor(const SceneQuery& scene, const torch::Tensor& root, double yaw, double height = 0);

/// The floor within 4.75 m of the origin. @param clearance metres from a place (x, z) to what stands there; asked for
/// every 0.1 m
FreeSpace floor_grid(const std::function<double(const Eigen::Vector2d&)>& clearance);
/// Whether the straight line comes nearer than 15 cm to something, its ends left out: somebody may sit there.
bool line_blocked(const FreeSpace& floor, const Eigen::Vector2d& from, const Eigen::Vector2d& to);
/// The path from one key to the next that A* finds, with room for swinging arms where it can be had. Nothing where
/// there is none of at most `longest` metres.
std::optional<WalkPath> path_around_obstacles(const FreeSpace& floor, const Eigen::Vector2d& from,
                                              const Eigen::Vector2d& to, double longest);

/// Metres around key frames that may be occupied: somebody sits there.
inline constexpr double kNearKeys = 0.45;
/// Metres: a line that comes nearer to something is blocked.
inline constexpr double kWide = 0.15;
/// Metres a frame: a path that needs a higher speed is not taken.
inline constexpr double kQuickest = 0.08;
/// Frames to either side that tell where a path leads.
inline constexpr int64_t kAlongPath = 3;

/// Two key frames, one after the other, that give the root, 0.9 m apart or more.
struct RootLeg {
  int64_t from;       ///< frame of the first
  int64_t to;         ///< frame of the second
  Eigen::Vector2d a;  ///< where the root is in the first, metres (x, z)
  Eigen::Vector2d b;  ///< and in the second
};
/// @param root (T, 3) metres, read in key frames only. @param groups (T, 25) what each frame constrains
std::vector<RootLeg> root_legs(const torch::Tensor& root, const torch::Tensor& groups);
/// (T, 3) metres, the roots of poses.
torch::Tensor root_places(const Poses& poses);

/// Detours of the root trajectory around obstacles, found by A* over the floor plan: offsets (T, 2) in metres along x
/// and z from the straight line between key frames, in the canonical frame of the first pose. An offset is zero in key
/// frames, and between two key frames where one of them does not constrain the root, where the straight line is free,
/// where there is no path or none that can be walked in the time, or outside the floor plan.
/// @param floor (96, 96) of scene_floor. @param root (T, 3) metres, read in key frames only. @param groups (T, 25)
/// which feature groups each key frame constrains (keyframes.h). @param unreached gets the key frames whose straight
/// line is blocked and that no path leads to in the time; may be null
torch::Tensor detours_around(const torch::Tensor& floor, const torch::Tensor& root, const torch::Tensor& groups,
                             std::vector<int64_t>* unreached = nullptr);

/// The same for the keys of a clip, in the world's axes, with the floor plan around its first frame.
/// @param clip read in key frames only. @param groups (T, 25), the first frame a whole key. @param floor metres, height
torch::Tensor detours_of_clip(const Clip& clip, const torch::Tensor& groups, const SceneQuery& scene, double floor,
                              std::vector<int64_t>* unreached = nullptr);

/// The same from the distances that a network of residual motion sees.
/// @param keys (T) poses, read in key frames only
torch::Tensor detours_of_poses(const Poses& keys, const torch::Tensor& groups, const SceneDistances& scene,
                               std::vector<int64_t>* unreached = nullptr);

/// Radians (T) about the vertical by which somebody is rotated who faces along a detour instead of along the straight
/// line: 0 in key frames, and within half a second of them part of it. @param straight (T) x, z metres of the root
/// without detours.
/// @param keys frames that give the root, in order
std::vector<double> yaws_along(const std::vector<Eigen::Vector2d>& straight, const torch::Tensor& detours,
                               const std::vector<int64_t>& keys);

/// Moves the interpolated baseline along the detours: root and joint positions of standardised features (B, 201, T) are
/// shifted by `detours` (B, T, 2), metres. @param mask (B, 201, T) 1 for constrained features, which stay. @param
/// deviation (201) of the standardisation.
torch::Tensor along_detours(const torch::Tensor& baseline, const torch::Tensor& detours, const torch::Tensor& mask,
                            const torch::Tensor& deviation);

}  // namespace inhabit::inbetween
