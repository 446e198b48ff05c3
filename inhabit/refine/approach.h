#pragma once
#include <cstdint>
#include <vector>

#include "inhabit/refine/scene_terms.h"
#include "inhabit/refine/trajectory.h"
#include "inhabit/scene/query.h"

namespace inhabit::refine {

/// A ball in a frame, and the place of the scene nearest to it.
struct BallPlace {
  int64_t frame;                                      ///< of the poses
  size_t ball;                                        ///< of the balls
  Eigen::Vector3d place;                              ///< of its middle, metres
  Eigen::Vector3d surface = Eigen::Vector3d::Zero();  ///< the nearest place of the scene, metres
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();   ///< of the face there, as the file has it
  double distance = 0;                                ///< metres from the middle to there
};

/// Which balls come near a scene or into it. A ball moves little from a frame to the next, and no surface is nearer
/// to it than its distance: most of what is far, and which side most of the others are on, need not be asked again.
class Approach {
 public:
  std::vector<BallPlace> near;  ///< frame by frame: those nearer than radius and `reach`, and all within kDeepest
  std::vector<char> inside;     ///< of each, whether its middle is in the scene

  /// Metres: what is nearer is looked at whatever its radius, as it may be deep inside.
  static constexpr double kDeepest = 0.25;

  Approach(const SceneQuery& solid, const std::vector<BodyBall>& balls, const Poses& poses, double reach);

 private:
  double wanted(size_t ball) const;
  Eigen::Vector3d place(int64_t frame, size_t ball) const;
  void ask(std::vector<BallPlace>& of) const;
  void find_near();
  void ask_inside(const std::vector<size_t>& of);
  /// On a path that meets no surface one frame in a few is asked, and what lies between two that agree is as they are:
  /// at the rim of an open shell, where in and out are no matter of surfaces, they may not agree.
  void find_inside();

  const SceneQuery& solid_;
  const std::vector<BodyBall>& balls_;
  const Poses& poses_;
  double reach_;
};

}  // namespace inhabit::refine
