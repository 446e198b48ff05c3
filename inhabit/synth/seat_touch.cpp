#include "inhabit/synth/seat_touch.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/random.h"

namespace inhabit {
namespace {

using Eigen::Vector3d;

/// The solid farthest out on the side `mirror` (+1 left) that is crossed at height y and depth z; null where none is.
const Box* outermost(const Furniture& piece, double mirror, double y, double z) {
  const Box* found = nullptr;
  for (const Box& box : piece.boxes) {
    if (std::abs(y - box.center.y()) > box.half.y() || std::abs(z - box.center.z()) > box.half.z()) continue;
    if (found == nullptr || mirror * (box.center - found->center).x() + box.half.x() - found->half.x() > 0)
      found = &box;
  }
  return found;
}

/// The board or cushion whose top is the seat.
const Box* seat_board(const Furniture& piece, const Seat& seat) {
  for (const Box& box : piece.boxes)
    if (std::abs(box.center.y() + box.half.y() - seat.height) < 1e-6 &&
        std::abs(seat.x - box.center.x()) < box.half.x() && box.center.z() + box.half.z() > seat.front - 0.03)
      return &box;
  return nullptr;
}

/// A hand against an upright face that looks outwards, fingers along `ahead`.
HandTrip hand_on_side(int side, const Vector3d& point, const Vector3d& out, const Vector3d& ahead,
                      const Figure& figure) {
  HandTrip trip;
  trip.side = side;
  trip.touches = true;
  trip.point = point;
  trip.pull.place = point - ahead * figure.palm_reach + out * figure.palm_depth;
  trip.pull.rotation = hand_rotation(side, ahead, -out);
  return trip;
}

}  // namespace

std::optional<HandTrip> touch_seat(SeatPart part, int side, const Furniture& piece, const Seat& seat,
                                   const Vector3d& root_world, const Figure& figure, std::mt19937_64& random) {
  const double mirror = side == 0 ? 1 : -1;
  const Eigen::Matrix3d rotation = seat.pose.linear();
  const Vector3d root = seat.pose.inverse() * root_world, out = rotation * Vector3d(mirror, 0, 0);
  HandTrip trip;
  if (part == SeatPart::arm_rest) {
    const auto arm = std::find_if(seat.arms.begin(), seat.arms.end(),
                                  [&](const Surface& a) { return (a.center.x() - seat.x) * mirror > 0; });
    if (arm == seat.arms.end()) return std::nullopt;
    const double x = arm->center.x() + uniform(random, -0.5, 0.5) * arm->half_width;
    if (std::abs(x - root.x()) > 0.48) return std::nullopt;
    const double z = std::clamp(root.z() + uniform(random, 0.16, 0.4), arm->center.z() - 0.85 * arm->half_depth,
                                arm->center.z() + 0.9 * arm->half_depth);
    const Vector3d ahead = Vector3d(mirror * uniform(random, -0.15, 0.2), 0, 1).normalized();
    trip = flat_hand(side, seat.pose * Vector3d(x, arm->center.y(), z), rotation * ahead, figure);
    trip.pull.swivel = uniform(random, 0.5, 0.9);
  } else if (part == SeatPart::back_rest) {
    if (!seat.back || !seat.arms.empty()) return std::nullopt;
    const double z = seat.back_z - 0.016;
    const double y = seat.height + uniform(random, 0.1, 0.26);
    const Box* post = outermost(piece, mirror, y, z);
    if (post == nullptr || std::abs(post->center.x() + mirror * post->half.x() - root.x()) > 0.4) return std::nullopt;
    const Vector3d point(post->center.x() + mirror * post->half.x(), y, z);
    const Vector3d ahead = Vector3d(-mirror * 0.05, -1, -0.35).normalized();
    trip = hand_on_side(side, seat.pose * point, out, rotation * ahead, figure);
    trip.pull.swivel = uniform(random, 0.9, 1.3);
  } else {
    const bool front = part == SeatPart::seat_front;
    const double edge = seat.x + mirror * seat.half_width;  // of the level part
    const double room_beside = mirror * (edge - root.x());
    const bool blocked = std::any_of(seat.arms.begin(), seat.arms.end(),
                                     [&](const Surface& a) { return (a.center.x() - seat.x) * mirror > 0; });
    if (room_beside < (front ? 0.17 : 0.13) || (blocked && room_beside < 0.23)) return std::nullopt;
    if (!front && !blocked && room_beside < 0.3) {
      // Round the edge of the seat, fingers down.
      const Box* board = seat_board(piece, seat);
      if (board == nullptr) return std::nullopt;
      const double z = std::min(root.z() + uniform(random, 0.02, 0.2), seat.front - 0.09);
      const Box* face = outermost(piece, mirror, board->center.y(), z);
      if (face != board) return std::nullopt;
      const Vector3d point(board->center.x() + mirror * board->half.x(), board->center.y(), z);
      const Vector3d ahead = Vector3d(0, -1, uniform(random, 0.3, 0.8)).normalized();
      trip = hand_on_side(side, seat.pose * point, out, rotation * ahead, figure);
      trip.pull.swivel = uniform(random, 0.6, 1.0);
    } else {
      const double beside = std::min(root.x() * mirror + uniform(random, 0.25, 0.33), edge * mirror - 0.01);
      const double z = front ? seat.front - uniform(random, 0.03, 0.08)
                             : std::clamp(root.z() + uniform(random, 0.0, 0.12), seat.rear + 0.03, seat.front - 0.1);
      const Vector3d ahead = Vector3d(mirror * uniform(random, front ? 0.1 : 0.3, 0.6), 0, 1).normalized();
      trip = flat_hand(side, seat.pose * Vector3d(mirror * beside, seat.height, z), rotation * ahead, figure);
      trip.pull.swivel = uniform(random, 0.5, 0.9);
    }
  }
  trip.arch = part == SeatPart::arm_rest ? 0.07 : 0.05;
  return trip;
}

}  // namespace inhabit
