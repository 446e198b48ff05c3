#pragma once
#include <torch/torch.h>

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "inhabit/inbetween/scene_probe.h"

namespace inhabit::inbetween {

// PathNet: where the root goes from one key to the next around what blocks the straight line, as a network sees it from
// above. Axes of the line: u along it from its middle, v to the left of who walks along it (+X where it leads along
// +Z). Paths are told as offsets from walking along the line at a steady pace, a sum of sines over the fraction s of
// the time: offset(s) = sum_k c_k sin(k pi s), so that both keys stay where they are.

/// Cells of the map, across and along the line, and metres of a cell: 6 by 8 m.
inline constexpr int64_t kMapWide = 48,    ///< cells across
    kMapLong = 64;                         ///< cells along
inline constexpr double kMapCell = 0.125;  ///< metres
/// Paths that are proposed, and sines of each.
inline constexpr int64_t kPathHypotheses = 4,  ///< paths
    kPathSines = 14;                           ///< sines of each of a path's two offsets
/// Fractions of the time at which PathNet looks at a path: (i + 0.5) / 32.
inline constexpr int64_t kPathPoints = 32;

/// The straight line between two keys, on the floor.
struct PathLine {
  Eigen::Vector2d from;  ///< metres (x, z)
  Eigen::Vector2d to;    ///< metres (x, z)

  /// Metres from end to end.
  double length() const { return (to - from).norm(); }
  /// A point of the line's axes in the world.
  Eigen::Vector2d world(double u, double v) const;
};

/// Metres to the nearest of what a scene has 0.2 to 1.7 m above the floor at (x, z), 0.8 at most.
float nearest_upright(const SceneDistances& scene, const Eigen::Vector2d& place);
/// Whether the line comes nearer than 15 cm to such things, its ends left out.
bool line_blocked(const SceneDistances& scene, const PathLine& line);

/// What PathNet sees (48, 64): 1 where nothing is within 0.8 m, falling to 0 at obstacles and inside.
torch::Tensor path_map(const SceneDistances& scene, const PathLine& line);
/// The same of distances (..., 48, 64) in metres.
torch::Tensor path_map(const torch::Tensor& distances);
/// The middle of a map's cell in the line's axes.
Eigen::Vector2d path_map_point(int64_t across, int64_t along);

/// Offsets (..., S, 2) along u and v, metres, of sines (..., 2, 14) at fractions (S) of the time.
torch::Tensor path_offsets(const torch::Tensor& sines, const torch::Tensor& times);
/// Places (..., S, 2) in the line's axes of somebody who walks along lines of `length` (...) at a steady pace, and of
/// sines (..., 2, 14) beside them; undefined sines: on the lines.
torch::Tensor path_places(const torch::Tensor& sines, const torch::Tensor& times, const torch::Tensor& length);
/// (32) fractions of the time at which PathNet looks.
torch::Tensor path_times();
/// Values (B, C, K, 32) of maps (B, C, 48, 64) at places (B, K, 32, 2) in the line's axes, bilinear.
torch::Tensor at_places(const torch::Tensor& maps, const torch::Tensor& places);

/// What PathNet proposes.
struct ProposedPaths {
  std::vector<torch::Tensor> rounds;  ///< (B, 4, 2, 14) sines after each round, the last one best
  torch::Tensor log_probability;      ///< (B, 4)
};

/// A convolutional network over the map proposes four paths and how likely each is; then, three times, a mixer over
/// each path's points looks at the map where the path is and moves it.
struct PathNetImpl : torch::nn::Module {
  /// With weights drawn at random by LibTorch's global generator.
  PathNetImpl();
  /// @param map (B, 48, 64) of path_map. @param length (B) metres of the lines
  ProposedPaths forward(const torch::Tensor& map, const torch::Tensor& length);

  torch::nn::Sequential fine{nullptr};        ///< map to 24 x 32 cells
  torch::nn::Sequential middle{nullptr};      ///< to 12 x 16
  torch::nn::Sequential coarse{nullptr};      ///< to 6 x 8
  torch::nn::Conv2d back_to_middle{nullptr};  ///< up again, beside what was there
  torch::nn::Conv2d back_to_fine{nullptr};    ///< likewise
  torch::nn::Sequential propose{nullptr};     ///< sines and log-probabilities from the coarsest cells
  torch::nn::Linear look{nullptr};            ///< what a point of a path sees to its token
  torch::nn::ModuleList mix{nullptr};         ///< over points and channels
  torch::nn::Linear move{nullptr};            ///< token to metres
  bool bfloat16 = false;                      ///< products in training are made in bfloat16 (nn/bfloat16.h)
};
TORCH_MODULE(PathNet);

}  // namespace inhabit::inbetween
