#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "inhabit/math/heading.h"
#include "inhabit/scene/free_space.h"

namespace inhabit {

/// A smooth path over the floor, points 2 cm apart.
struct WalkPath {
  std::vector<Eigen::Vector2d> points;  ///< metres, world (x, z)
  std::vector<double> length;           ///< metres from the start to each point

  /// Metres from the start to the end.
  double total() const { return length.empty() ? 0 : length.back(); }
  /// World (x, z) at `s` metres from the start, 0 to total().
  Eigen::Vector2d at(double s) const;
  /// Radians in which the path leads there: 0 is +Z, pi/2 is +X.
  double heading(double s) const;
};

/// A path from `from` to `to` that keeps about `margin` metres from everything, A* over a grid of 0.1 m, then
/// smoothed; at its ends it may come nearer. Nothing when there is none.
std::optional<WalkPath> find_path(const FreeSpace& floor, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                  double margin);

}  // namespace inhabit
