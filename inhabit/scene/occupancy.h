#pragma once
#include <torch/types.h>

#include <Eigen/Core>
#include <array>

#include "inhabit/scene/solid.h"

namespace inhabit {

/// A grid of cubes around a person. The default is what scene-aware in-betweening looks at.
struct OccupancyShape {
  std::array<int, 3> cells{48, 24, 48};  ///< along the person's left, up, and ahead
  double cell = 0.1;                     ///< edge, metres
};

/// Which cells of a grid the scene fills: (cells[0], cells[1], cells[2]) float, 1 where a surface, a point of the cloud
/// or the inside of a body (see Solid) is in the cell, -1 where the cell is free. A cell is inside when its middle is,
/// by winding numbers along the grid's own six directions; that a surface passes through it is decided exactly.
/// @param center the grid's middle, metres, world: the root joint of the first frame. @param heading radians about +Y
/// by which the person is rotated from facing +Z: cell [i][j][k] lies ahead of the person for large k, on the left for
/// large i. Throws Error when the shape has no cell or more than 2^28.
torch::Tensor occupancy_grid(const Solid& solid, const Eigen::Vector3d& center, double heading,
                             const OccupancyShape& shape = {});

}  // namespace inhabit
