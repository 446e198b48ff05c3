#pragma once
#include <optional>

#include "inhabit/interact/chair.h"
#include "inhabit/scene/walk_path.h"

namespace inhabit::interact {

/// Metres from a path to what stands beside it: as much as there is, between elbow room and what somebody who squeezes
/// through needs. With kElbowRoom people of the generated data walk.
inline constexpr double kElbowRoom = 0.42,  ///< at most
    kSqueeze = 0.24;                        ///< at least

/// A route over the floor to a place, the one with most room of those that are not much longer than the shortest. At
/// its ends it may be nearer to what stands there. Nothing where there is none.
std::optional<WalkPath> find_route(const FreeSpace& floor, const Eigen::Vector2d& from, const Eigen::Vector2d& to);

/// A route to where one stands before sitting down: before the seat, or, where that is taken (a table), as far to its
/// side as one must. Nothing where there is none.
std::optional<WalkPath> find_route(const FreeSpace& floor, const Eigen::Vector2d& from, const Chair& chair);

/// From a chair to a place.
std::optional<WalkPath> find_route(const FreeSpace& floor, const Chair& chair, const Eigen::Vector2d& to);

/// Whether one may walk straight from one place to another, `clear` metres from everything. Near `to` less will do, as
/// in find_path.
bool straight(const FreeSpace& floor, const Eigen::Vector2d& from, const Eigen::Vector2d& to, double clear);

}  // namespace inhabit::interact
