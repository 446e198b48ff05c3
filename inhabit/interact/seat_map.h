#pragma once
#include <Eigen/Core>
#include <vector>

#include "inhabit/scene/scene.h"

namespace inhabit::interact {

/// What of a piece of furniture is seen from straight above, on a grid over the floor. Metres, world.
struct TopView {
  double cell = 0.02;                               ///< between neighbouring grid points
  Eigen::Vector2d origin{Eigen::Vector2d::Zero()};  ///< (x, z) of grid point (0, 0)
  int nx = 0;                                       ///< grid points along x
  int nz = 0;                                       ///< grid points along z
  double floor = 0;                                 ///< height of its lowest point
  std::vector<float> height;                        ///< over the floor, nz rows of nx; negative where there is nothing
  std::vector<char> level;                          ///< whether one could sit there: nearly horizontal

  /// Where a grid point stands in the lists below.
  size_t at(int ix, int iz) const {
    return static_cast<size_t>(iz) * static_cast<size_t>(nx) + static_cast<size_t>(ix);
  }
  /// World (x, z) of a grid point.
  Eigen::Vector2d point(int ix, int iz) const { return origin + cell * Eigen::Vector2d(ix, iz); }
};

/// @param mesh of at least one face, at most 10 m on a side. Throws Error(name of the mesh, ...) for a larger one.
TopView view_from_above(const Mesh& mesh);

/// A connected, nearly level area.
struct LevelArea {
  std::vector<Eigen::Vector2d> points;  ///< grid points (x, z)
  double height = 0;                    ///< over the floor, their median
  double inner_radius = 0;              ///< of the largest disc in it
};

/// The areas between two heights over the floor, gaps of up to 6 cm (slats) bridged; the largest disc first.
std::vector<LevelArea> level_areas(const TopView& view, double low, double high);

/// Heading (radians) of one side of the smallest rectangle around points on the floor.
double rectangle_heading(const std::vector<Eigen::Vector2d>& points);

}  // namespace inhabit::interact
