#pragma once
#include <Eigen/Core>
#include <limits>
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

/// By how much a path may be longer for having more room.
struct LongerPath {
  double times = 1;                                          ///< the length of the shortest,
  double more = 0;                                           ///< plus metres,
  double longest = std::numeric_limits<double>::infinity();  ///< and metres at most
};

/// The path with most room of those that are not much longer than the shortest: that of the first of `margins`, widest
/// first, whose path `longer` allows. Nothing where there is none.
std::optional<WalkPath> find_roomy_path(const FreeSpace& floor, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                        const std::vector<double>& margins, const LongerPath& longer);

}  // namespace inhabit
