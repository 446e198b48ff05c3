#include "inhabit/synth/seat.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/heading.h"
#include "inhabit/math/random.h"

namespace inhabit {

using Eigen::Vector2d;
using Eigen::Vector3d;

HandTrip flat_hand(int side, const Vector3d& point, const Vector3d& ahead, const Figure& figure) {
  HandTrip trip;
  trip.side = side;
  trip.touches = true;
  trip.point = point;
  trip.pull.place = point - ahead * figure.palm_reach + Vector3d(0, figure.palm_depth, 0);
  trip.pull.rotation = hand_rotation(side, ahead, -Vector3d::UnitY());
  return trip;
}

HandTrip thigh_hand(int side, const Figure& figure, std::mt19937_64& random) {
  const double mirror = side == 0 ? 1 : -1;
  HandTrip trip;
  trip.side = side;
  trip.pull.anchor = 1 + side;
  trip.pull.place = figure.bones.offsets[4 + side] * uniform(random, 0.48, 0.68) +
                    Vector3d(mirror * uniform(random, -0.03, 0.03), 0, figure.thigh_depth + figure.palm_depth);
  const Vector3d ahead = Vector3d(-mirror * uniform(random, 0.1, 0.6), -1, -0.12).normalized();
  trip.pull.rotation = hand_rotation(side, ahead, -Vector3d::UnitZ());
  trip.pull.swivel = uniform(random, 0.2, 0.6);
  trip.arch = 0.04;
  return trip;
}

std::vector<Seat> seats_of(const Room& room, const Figure& figure, double bed_part) {
  std::vector<Seat> seats;
  for (size_t f = 0; f < room.furniture.size(); ++f) {
    const Furniture& piece = room.furniture[f];
    for (const Surface& s : piece.surfaces) {
      if (s.kind != Surface::Kind::seat && s.kind != Surface::Kind::bed) continue;
      // Too low or too high for these legs.
      if (s.center.y() < 0.55 * figure.shank || s.center.y() > 1.35 * figure.shank) continue;
      Seat seat;
      seat.furniture = static_cast<int>(f);
      seat.pose = piece.pose;
      seat.x = s.center.x();
      seat.height = s.center.y();
      seat.half_width = s.half_width;
      seat.front = s.center.z() + s.half_depth;
      seat.rear = s.center.z() - s.half_depth;
      if (s.kind == Surface::Kind::bed) {
        // Beds are sat on at their long sides, facing out.
        for (const double side : {-1.0, 1.0}) {
          Seat edge = seat;
          edge.pose = piece.pose * Eigen::AngleAxisd(side * M_PI / 2, Vector3d::UnitY());
          edge.x = -side * s.center.z();
          edge.half_width = s.half_depth * bed_part;
          edge.front = s.half_width + side * s.center.x();
          edge.rear = edge.front - 2 * s.half_width;
          edge.heading = heading_of(on_ground(edge.pose.linear().col(2)));
          seats.push_back(edge);
        }
        continue;
      }
      seat.heading = heading_of(on_ground(piece.pose.linear().col(2)));
      seat.back = piece.back_height > s.center.y() + 0.25;
      seat.back_z = piece.back_z;
      for (const Surface& arm : piece.surfaces) {
        const bool rest = arm.kind == Surface::Kind::arm_rest_left || arm.kind == Surface::Kind::arm_rest_right;
        if (rest && std::abs(arm.center.x() - seat.x) < 0.45) seat.arms.push_back(arm);
      }
      seats.push_back(seat);
    }
  }
  return seats;
}

Vector2d stand_place(const Seat& seat, const Figure& figure, std::mt19937_64& random, double aside) {
  const double sideways = std::max(0.0, seat.half_width - 0.24);
  const double x = seat.x + std::min(sideways, aside) * uniform(random, -0.8, 0.8);
  const double ankle = seat.front + 0.085 + uniform(random, 0.0, 0.05);
  const Vector3d p = seat.pose * Vector3d(x, 0, ankle - figure.ankle_ahead);
  return {p.x(), p.z()};
}

SeatStay plan_stay(const Seat& seat, const Figure& figure, const Vector2d& place, std::mt19937_64& random) {
  const Vector3d stand = seat.pose.inverse() * Vector3d(place.x(), 0, place.y());
  SeatStay stay;
  stay.furniture = seat.furniture;
  // Shanks near upright: knees over the ankles or a little ahead.
  const double shank_lean = uniform(random, -0.02, 0.06);
  double z = stand.z() + figure.ankle_ahead + shank_lean - 0.97 * figure.thigh;
  z = std::max(z, seat.rear + 0.1);
  if (seat.back) z = std::max(z, seat.back_z + figure.back_depth + uniform(random, 0.005, 0.04));
  z = std::min(z, seat.front - 0.13);
  stay.root = seat.pose * Vector3d(stand.x(), seat.height + figure.seat_depth, z);
  stay.deepest_lean = std::clamp(0.62 + 1.2 * (0.46 - seat.height) + 0.06 * normal(random), 0.45, 0.95);
  return stay;
}

void plan_seat_hands(const Seat& seat, const SeatStay& stay, const Figure& figure, std::mt19937_64& random,
                     std::vector<HandTrip>& hands) {
  const Vector3d root = seat.pose.inverse() * stay.root;
  const Vector3d ahead = seat.pose.linear().col(2);
  const bool on_way_down = chance(random, 0.55), on_way_up = chance(random, 0.55), stays = chance(random, 0.45);
  const int down_hands = uniform_int(random, 0, 2), up_hands = uniform_int(random, 0, 2);  // left, right, both
  const double going = stay.seated - stay.down, rising = stay.risen - stay.rise;
  const bool edge_of_seat = seat.arms.empty() && seat.half_width < 0.5;
  for (int side = 0; side < 2; ++side) {
    const double mirror = side == 0 ? 1 : -1;
    const Surface* arm = nullptr;
    for (const Surface& a : seat.arms)
      if ((a.center.x() - seat.x) * mirror > 0) arm = &a;
    const bool down = on_way_down && (down_hands == 2 || down_hands == side);
    const bool up = on_way_up && (up_hands == 2 || up_hands == side);
    const bool can = arm != nullptr || edge_of_seat || seat.half_width >= 0.5;
    Vector3d local(0, 0, 0);
    if (arm != nullptr) {
      const double z = std::clamp(root.z() + uniform(random, 0.22, 0.36), arm->center.z() - 0.85 * arm->half_depth,
                                  arm->center.z() + 0.92 * arm->half_depth);
      local = {arm->center.x(), arm->center.y(), z};
    } else {
      double x = root.x() + mirror * 0.27;
      x = std::clamp(x, seat.x - seat.half_width + 0.015, seat.x + seat.half_width - 0.015);
      local = {x, seat.height, std::clamp(root.z() + uniform(random, 0.02, 0.12), seat.rear + 0.02, seat.front - 0.04)};
    }
    const Vector3d out = seat.pose.linear() * Vector3d(mirror, 0, 0);
    const Vector3d fingers = (ahead + (arm != nullptr ? 0.05 : 0.45) * out).normalized();
    HandTrip rest = flat_hand(side, seat.pose * local, fingers, figure);
    rest.pull.swivel = uniform(random, 0.5, 0.9);
    rest.arch = 0.05;
    HandTrip lap = thigh_hand(side, figure, random);
    const double free_from = stay.seated + 0.15, free_until = stay.rise;
    double lap_from = stay.down + 0.6 * going, lap_until = free_until + 0.25 * rising;
    if (can && down) {
      rest.when = {stay.down + 0.25 * going, stay.down + 0.8 * going, free_from + uniform(random, 0.1, 0.8), 0};
      if (stays && arm != nullptr) rest.when.fall = std::max(rest.when.fall, free_until - 1.2);
      rest.when.fall = std::min(rest.when.fall, free_until - 0.75);
      rest.when.end = rest.when.fall + 0.7;
      lap_from = rest.when.fall - 0.05;
      if (rest.when.fall > rest.when.full) hands.push_back(rest);
    }
    if (can && up) {
      HandTrip push = rest;
      push.when = {free_until - 0.75, free_until - 0.05, stay.rise + 0.5 * rising, stay.rise + 0.95 * rising};
      lap_until = free_until - 0.7;
      if (lap_until - lap_from > 0.9) {
        lap.when = {lap_from, lap_from + 0.75, lap_until, lap_until + 0.6};
        hands.push_back(lap);
      }
      hands.push_back(push);
    } else if (lap_until - lap_from > 0.9) {
      lap.when = {lap_from, lap_from + 0.75, lap_until, lap_until + 0.5 * rising};
      hands.push_back(lap);
    }
  }
}

}  // namespace inhabit
