#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "inhabit/scene/free_space.h"
#include "inhabit/synth/room.h"

namespace inhabit {

/// The floor of a room, as far as a person who stands can use it.
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
