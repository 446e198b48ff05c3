#pragma once
#include <Eigen/Core>
#include <functional>
#include <random>
#include <vector>

#include "inhabit/synth/room.h"
#include "inhabit/synth/room_space.h"

namespace inhabit {

/// A rectangle on the floor: half sizes along the x and z of a frame rotated by `yaw` from +Z towards +X.
struct Patch {
  Eigen::Vector2d center;  ///< world (x, z), metres
  Eigen::Vector2d half;    ///< half its sides
  double yaw = 0;          ///< radians
};
/// Whether two patches overlap; those that only touch do not.
bool overlap(const Patch& a, const Patch& b);
/// What a piece covers of the floor, and `margin` metres around it.
Patch footprint(const Furniture& piece, double margin = 0);

/// Length of wall `side` of a room.
inline double wall_length(const Eigen::Vector2d& size, int side) { return side % 2 == 0 ? size.x() : size.y(); }

/// A point on wall `side` (0: -z, 1: +x, 2: +z, 3: -x) of a room, and the yaw with which a piece there faces the room.
struct AtWall {
  Eigen::Vector2d point;  ///< world (x, z), metres
  double yaw;             ///< radians from +Z towards +X
};
/// @param along metres along the wall from its middle; @param in metres into the room.
AtWall at_wall(const Eigen::Vector2d& size, int side, double along, double in);
/// Places `piece` with its back `gap` metres from a random place of a random wall, often in a corner.
void put_at_wall(Furniture& piece, const Room& room, std::mt19937_64& random, double gap);

/// Furniture in a room while it is being added: keeps pieces inside and apart, openings free and seats in reach.
class Layout {
 public:
  /// `room` has its walls, and maybe furniture already; pieces go into it. @param openings of its walls.
  Layout(Room& room, const std::vector<Opening>& openings);

  /// From now on a piece must also pass this test, and seats need not be within walking reach: somebody's path through
  /// the room is known.
  void require(std::function<bool(const Furniture&)> test) { test_ = std::move(test); }

  /// Adds all of `pieces`, or none: inside the room, apart from one another and from all that must stay free, and with
  /// every seat so far within walking reach. `need` must stay free from then on.
  bool add(const std::vector<Furniture>& pieces, const std::vector<Patch>& need);
  /// Takes the last piece away, and every need for free space but that of doors.
  void remove_last();
  /// The room so far.
  const Room& room() const { return room_; }

 private:
  bool inside(const Patch& p, double margin) const;

  Room& room_;
  FreeSpace space_;
  std::vector<Patch> solid_, free_, low_;
  std::vector<Eigen::Vector2d> goals_;
  size_t doors_ = 0;
  std::function<bool(const Furniture&)> test_;
};

/// Fills a room as people do: beds, sofas, tables with chairs, desks, shelves, single seats.
void furnish(Layout& layout, std::mt19937_64& random);
/// Adds one seat, if need be by removing other pieces.
void add_any_seat(Layout& layout, std::mt19937_64& random);

}  // namespace inhabit
