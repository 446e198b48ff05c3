#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "inhabit/synth/room.h"

namespace inhabit {

/// How far every place on a room's floor is from the nearest wall or piece of furniture lower than a person is tall.
struct FreeSpace {
  double cell = 0.05;      ///< metres between neighbouring grid points
  Eigen::Vector2d origin;  ///< world (x, z) of grid point (0, 0)
  int nx = 0, nz = 0;
  /// Metres, nz rows of nx; exact at grid points up to kFarthest and cut off there; negative inside a solid.
  std::vector<float> clearance;

  static constexpr double kFarthest = 1.0;

  Eigen::Vector2d point(int ix, int iz) const { return origin + cell * Eigen::Vector2d(ix, iz); }
  /// Bilinear clearance at (x, z), metres; -kFarthest outside the room.
  double at(const Eigen::Vector2d& p) const;
  /// Direction in which the clearance at (x, z) grows fastest (unit length, or zero where it is flat).
  Eigen::Vector2d away(const Eigen::Vector2d& p) const;
};

FreeSpace free_space(const Room& room);
/// Takes one more piece into account.
void add_obstacle(FreeSpace& space, const Furniture& piece);

/// Whether a person of this radius (metres) can stand at (x, z).
inline bool walkable(const FreeSpace& space, const Eigen::Vector2d& p, double radius) { return space.at(p) >= radius; }

/// For each grid point 0 where a person of this radius cannot stand, else the number (from 1) of the connected region
/// it lies in; regions are numbered by falling area, so that 1 is the main one.
std::vector<int32_t> walkable_regions(const FreeSpace& space, double radius);

/// Where a person stands before sitting down on a surface, world (x, z): in front of the seat's front edge.
Eigen::Vector2d place_before(const Furniture& piece, const Surface& surface, double distance = 0.25);

}  // namespace inhabit
