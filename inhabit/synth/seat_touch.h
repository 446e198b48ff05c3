#pragma once
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "inhabit/synth/seat.h"

namespace inhabit {

/// Where a hand takes hold of what one sits on.
enum class SeatPart { arm_rest, seat_front, seat_side, back_rest };
/// "armrest", "front", "side", "back", as interact::contact_areas() has them.
const std::vector<std::string>& seat_part_names();

/// A hand on `part` of `piece` for somebody whose root rests at `root` (world) on `seat`: on the top of an arm rest, on
/// the seat near its front edge beside the knee, at the side of the seat (its edge, or beside the hip where the seat is
/// broad), at the side of the back rest. Nothing where the piece has no such place on that side (0 left, 1 right) or it
/// is out of reach. HandTrip::when is left to the caller.
std::optional<HandTrip> touch_seat(SeatPart part, int side, const Furniture& piece, const Seat& seat,
                                   const Eigen::Vector3d& root, const Figure& figure, std::mt19937_64& random);

}  // namespace inhabit
