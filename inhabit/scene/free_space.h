#pragma once
#include <Eigen/Geometry>
#include <vector>

#include "inhabit/scene/scene.h"

namespace inhabit {

/// How far every place on a floor is from the nearest wall or piece of furniture lower than a person is tall.
struct FreeSpace {
  double cell = 0.05;      ///< metres between neighbouring grid points
  Eigen::Vector2d origin;  ///< world (x, z) of grid point (0, 0)
  int nx = 0;              ///< grid points along x
  int nz = 0;              ///< grid points along z
  /// Metres, nz rows of nx; exact at grid points up to kFarthest and cut off there; negative inside a solid.
  std::vector<float> clearance;

  static constexpr double kFarthest = 1.0;  ///< metres

  /// World (x, z) of a grid point.
  Eigen::Vector2d point(int ix, int iz) const { return origin + cell * Eigen::Vector2d(ix, iz); }
  /// Bilinear clearance at (x, z), metres; -kFarthest outside the grid.
  double at(const Eigen::Vector2d& p) const;
  /// Direction in which the clearance at (x, z) grows fastest (unit length, or zero where it is flat).
  Eigen::Vector2d away(const Eigen::Vector2d& p) const;
};

/// The floor y = 0 around the obstacles of a scene (obstacles_of), as far as a person who stands can use it: whatever a
/// mesh has between 5 cm and 1.95 m over the floor stands in the way, what hangs higher is walked under. The grid goes
/// on for `beyond` metres on all sides of them and of `also` (x, z); farther out all is free. Solids are hollow: no
/// path leads into them. Clearances are exact but for millimetres. Throws Error where the grid would be larger than 200
/// m on a side.
FreeSpace free_space(const Scene& obstacles, double beyond = 3, const Eigen::AlignedBox2d& also = {});

}  // namespace inhabit
