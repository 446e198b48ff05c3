#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "inhabit/synth/room.h"

namespace inhabit {

// On the floor a point is (x, z) and a heading is an angle from +Z towards +X, as a turn about +Y.

/// Unit vector of a heading, (x, z).
Eigen::Vector2d ahead_of(double heading);
/// Unit vector to the left of a heading, (x, z).
Eigen::Vector2d left_of(double heading);
double heading_of(const Eigen::Vector2d& direction);
/// The same angle in (-pi, pi].
double wrapped(double angle);

/// A smooth way over the floor, points 2 cm apart.
struct WalkPath {
  std::vector<Eigen::Vector2d> points;
  std::vector<double> length;  ///< metres from the start to each point

  double total() const { return length.empty() ? 0 : length.back(); }
  Eigen::Vector2d at(double s) const;
  double heading(double s) const;
};

/// Where a room's floor is free: solid boxes below head height, seen from above.
class FloorPlan {
 public:
  explicit FloorPlan(const Room& room);

  /// Metres to the nearest obstacle, negative inside.
  double clearance(const Eigen::Vector2d& point) const;
  bool inside(const Eigen::Vector2d& point) const;  ///< within the walls
  /// A way from `from` to `to` that keeps about `margin` from obstacles, A* over a grid and then drawn smooth;
  /// nothing when there is none.
  std::optional<WalkPath> way(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double margin = 0.3) const;

 private:
  struct Obstacle {
    Eigen::Vector2d center, axis, half;  ///< axis: the obstacle's own x on the floor
  };
  std::vector<Obstacle> obstacles_;
  Eigen::Vector2d half_size_;
  int columns_ = 0, rows_ = 0;
  std::vector<float> grid_;  ///< clearance at cell middles

  Eigen::Vector2d middle(int cell) const;
  int cell_at(const Eigen::Vector2d& point) const;
  void smooth(std::vector<Eigen::Vector2d>& points, double margin) const;
};

}  // namespace inhabit
