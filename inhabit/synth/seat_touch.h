#pragma once
#include <optional>
#include <random>

#include "inhabit/synth/chair_life.h"
#include "inhabit/synth/seat.h"

namespace inhabit {

/// A hand on `part` of `piece` for somebody whose root rests at `root` (world) on `seat`: on the top of an arm rest, on
/// the seat near its front edge beside the knee, at the side of the seat (its edge, or beside the hip where the seat is
/// broad), at the side of the back rest. Nothing where the piece has no such place on that side (0 left, 1 right) or it
/// is out of reach. HandTrip::when is left to the caller.
std::optional<HandTrip> touch_seat(SeatPart part, int side, const Furniture& piece, const Seat& seat,
                                   const Eigen::Vector3d& root, const Figure& figure, std::mt19937_64& random);

}  // namespace inhabit
