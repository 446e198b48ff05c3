#pragma once
#include <torch/types.h>

#include <array>
#include <memory>
#include <vector>

#include "inhabit/inbetween/baseline.h"
#include "inhabit/scene/scene.h"

namespace inhabit::inbetween {

/// Points of the body whose distance to the scene is looked at: the joints, then the middles of thighs, shanks, upper
/// arms and forearms.
inline constexpr int64_t kBodyPoints = kStandardJoints + 8;
/// Numbers that a body point gives the network: closeness and its gradient; the fan gives closenesses.
inline constexpr int64_t kPointFeatures = 4 * kBodyPoints,  ///< of all body points
    kFanFeatures = 75;                                      ///< of the fan (scene_fan)

/// The distance to a scene's obstacles (all but floors, rugs and the ground of a scan; points of a cloud, too) where
/// people are, at the corners of a grid of 0.1 m and interpolated between them. Found once, so that thousands of scenes
/// can be kept (some 300 KB each). Copies share it.
class SceneDistances {
 public:
  SceneDistances() = default;  ///< nothing to collide with
  /// @param floor metres, which is height 0 here. @param around the places that will be asked for; the grid covers
  /// these and no more than 0.8 m around obstacles. Empty: all obstacles. Throws Error where there are more than 2^27
  /// corners.
  explicit SceneDistances(const Scene& scene, double floor = 0, const Eigen::AlignedBox3f& around = {});

  /// Metres to the nearest obstacle, negative inside; kFar beyond the grid. @param gradient where not null, that of the
  /// distance (metres a metre; 0 beyond the grid).
  float distance(const Eigen::Vector3f& point, Eigen::Vector3f* gradient = nullptr) const;
  /// The scene as a mirror at x = 0 shows it.
  SceneDistances mirrored() const;

  static constexpr float kFar = 10;  ///< metres that places beyond the grid are said to be away

 private:
  struct Grid;
  std::shared_ptr<const Grid> grid_;
  float floor_ = 0, side_ = 1;  // side_: -1 where mirrored
};

/// What a network sees of the scene around the baseline (T, 75): closeness at points on three circles about the root
/// and at the root itself, at the height of shanks, hips and chest, in the heading frame. Closeness is 1 at a surface,
/// 0 from 0.8 m on, more than 1 inside.
torch::Tensor scene_fan(const SceneDistances& scene, const Baseline& baseline);

/// The middles of the fan's circles, one above the other at the root's place (..., 3, 3). @param root (..., 3) metres,
/// floor at y = 0. Differentiable.
torch::Tensor root_column(const torch::Tensor& root);

/// Body points (..., 30, 3) of joints (..., 22, 3). Differentiable.
torch::Tensor body_points(const torch::Tensor& joints);
/// Metres of flesh around each (30).
torch::Tensor body_point_radii();

/// What goes on beyond the last joint of a limb: palms, fingertips, thumbs and toes.
struct LimbEnd {
  int64_t joint;           ///< the limb's last, standard order
  Eigen::Vector3f offset;  ///< metres from it, in its frame
  float radius;            ///< metres that the penetration loss keeps free around it
};
inline constexpr size_t kLimbEnds = 8;  ///< how many there are
/// Of the built-in body, left and right in turn.
const std::array<LimbEnd, kLimbEnds>& limb_ends();

/// Metres that the penetration loss keeps free around body points and then limb ends (38).
torch::Tensor guarded_radii();

/// Distances of points to a scene, as SceneDistances::distance has them.
struct ProbedPoints {
  torch::Tensor distance;  ///< (...) metres, negative inside
  torch::Tensor gradient;  ///< (..., 3) metres a metre, world
};
/// Distances of points (..., 3), world metres, to a scene; float32 on the CPU.
ProbedPoints probe(const SceneDistances& scene, const torch::Tensor& points);
/// Of points (B, ...) of B windows, each in its own scene; on the points' device.
ProbedPoints probe(const std::vector<SceneDistances>& scenes, const torch::Tensor& points);

/// What a network sees of probed body points (B, T, 30): closeness and the gradient of it in the heading frame (B, T,
/// 120). @param rotation (B, T, 3, 3) heading frame to world
torch::Tensor point_features(const ProbedPoints& probed, const torch::Tensor& rotation);

}  // namespace inhabit::inbetween
