#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "inhabit/body/body_model.h"
#include "inhabit/motion/clip.h"
#include "inhabit/synth/furniture.h"

namespace inhabit {

/// All places that a body's capsules take over a clip, as balls, for asking what a piece of furniture would touch.
class BodySweep {
 public:
  /// A place that a part of the body takes.
  struct Ball {
    Eigen::Vector3d center;  ///< world, metres
    double radius;           ///< metres
    int joint;               ///< whose capsule it is of
    int frame;               ///< of the clip
  };
  /// How near a ball of each joint may come: metres, negative where it may sink in.
  using Gaps = std::array<double, kStandardJoints>;

  /// Needs rotations and trans on the standard skeleton. Balls lie 4 cm apart or closer along capsules; those of a
  /// place that has moved less than 8 mm since its last ball are left out.
  BodySweep(const Clip& clip, const BodyModel& body);

  /// Whether some ball is nearer to a box of the piece than its joint may come.
  bool touches(const Furniture& piece, const Gaps& gaps) const;
  /// All of them.
  const std::vector<Ball>& balls() const { return balls_; }
  Eigen::Vector2d low() const { return low_; }    ///< (x, z) of the rectangle on the floor around all balls
  Eigen::Vector2d high() const { return high_; }  ///< its opposite corner

 private:
  size_t cell(int x, int z) const { return static_cast<size_t>(z) * static_cast<size_t>(nx_) + static_cast<size_t>(x); }
  std::vector<Ball> balls_;
  Eigen::Vector2d low_, high_;
  int nx_ = 1, nz_ = 1;
  std::vector<std::vector<int>> cells_;  // balls by where their centres are on the floor
  double largest_ = 0;
};

}  // namespace inhabit
