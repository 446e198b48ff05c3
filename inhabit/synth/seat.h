#pragma once
#include <random>
#include <vector>

#include "inhabit/synth/life_plan.h"

namespace inhabit {

/// A place to sit on a piece of furniture. Lengths in the furniture's frame (`pose` to world).
struct Seat {
  int furniture = -1;                                      ///< index into Room::furniture
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< of the furniture
  double heading = 0;                                      ///< that a seated person faces, world
  double x = 0;                                            ///< middle of the seat
  double height = 0;                                       ///< of the seat over the floor
  double half_width = 0;                                   ///< along x
  double front = 0;                                        ///< z of its front edge
  double rear = 0;                                         ///< z of its rear edge
  bool back = false;                                       ///< there is a back rest, at back_z
  double back_z = 0;                                       ///< of the back rest's front face
  std::vector<Surface> arms;                               ///< arm rests within reach
};

/// All seats of a room that fit the length of this person's shanks; beds are sat on at their long sides, on `bed_part`
/// of what the blanket covers, around its middle.
std::vector<Seat> seats_of(const Room& room, const Figure& figure, double bed_part = 0.7);

/// Where one stands before sitting down, backs of the legs near the edge (x, z), at most 0.8 `aside` (m) from the
/// seat's middle.
Eigen::Vector2d stand_place(const Seat& seat, const Figure& figure, std::mt19937_64& random, double aside = 0.25);

/// Where the root will rest for somebody who stands at `place`; times are left to the caller.
SeatStay plan_stay(const Seat& seat, const Figure& figure, const Eigen::Vector2d& place, std::mt19937_64& random);

/// A hand flat on a level surface at `point` (world), fingers along `ahead`.
HandTrip flat_hand(int side, const Eigen::Vector3d& point, const Eigen::Vector3d& ahead, const Figure& figure);
/// A hand on its own thigh, in the thigh's frame.
HandTrip thigh_hand(int side, const Figure& figure, std::mt19937_64& random);

/// What the hands do on the way down, while seated (on the thighs, on arm rests) and on the way up.
void plan_seat_hands(const Seat& seat, const SeatStay& stay, const Figure& figure, std::mt19937_64& random,
                     std::vector<HandTrip>& hands);

}  // namespace inhabit
