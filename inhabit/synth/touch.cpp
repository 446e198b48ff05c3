#include "inhabit/synth/touch.h"

#include <cmath>

#include "inhabit/math/heading.h"
#include "inhabit/math/random.h"

namespace inhabit {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::vector<TouchPlace> touch_places(const Room& room) {
  std::vector<TouchPlace> places;
  for (size_t f = 0; f < room.furniture.size(); ++f) {
    const Furniture& piece = room.furniture[f];
    for (const Surface& s : piece.surfaces) {
      const bool table = s.kind == Surface::Kind::table, shelf = s.kind == Surface::Kind::shelf;
      if (!(table && s.center.y() > 0.55) && !(shelf && s.center.y() > 0.65 && s.center.y() < 1.55)) continue;
      // A table is reached from all four sides, a shelf from its front.
      for (int side = 0; side < (table ? 4 : 1); ++side) {
        const bool along_x = side % 2 == 0;
        const double sign = side < 2 ? 1 : -1;
        const Vector3d out = along_x ? Vector3d(0, 0, sign) : Vector3d(sign, 0, 0);
        TouchPlace place;
        place.furniture = static_cast<int>(f);
        place.edge = piece.pose * Vector3d(s.center + out * (along_x ? s.half_depth : s.half_width));
        place.inward = piece.pose.linear() * -out;
        place.half_length = along_x ? s.half_width : s.half_depth;
        place.depth = 2 * (along_x ? s.half_depth : s.half_width);
        places.push_back(place);
      }
    }
  }
  return places;
}

std::optional<TouchPlan> plan_touch(const TouchPlace& place, const FreeSpace& floor, const Figure& figure,
                                    std::mt19937_64& random) {
  const Vector3d along = place.inward.cross(Vector3d::UnitY());  // to the right of somebody who faces inward
  TouchPlan plan;
  const Vector2d inward(place.inward.x(), place.inward.z());
  const double across = uniform(random, -1, 1) * std::max(0.0, place.half_length - 0.15);
  const Vector3d before = place.edge + along * across - place.inward * uniform(random, 0.34, 0.42);
  plan.stand = {before.x(), before.z()};
  if (floor.at(plan.stand) < 0.24) return std::nullopt;
  plan.heading = heading_of(inward) + uniform(random, -0.12, 0.12);

  plan.before_edge = -0.2 * place.inward + Vector3d(0, place.edge.y() < 1.0 ? 0.12 : 0.05, 0);
  const int which = uniform_int(random, 0, 4);  // left twice, right twice, both
  for (int side = 0; side < 2; ++side) {
    if (which < 4 && which % 2 != side) continue;
    const double mirror = side == 0 ? 1 : -1;
    HandTrip trip;
    trip.side = side;
    trip.touches = true;
    const double sideways = -mirror * uniform(random, 0.08, 0.26);
    const double room_left = place.half_length - 0.04;
    const double x = std::clamp(across + sideways, -room_left, room_left);
    trip.point = place.edge + along * x + place.inward * std::min(uniform(random, 0.05, 0.2), 0.6 * place.depth);
    Vector3d shoulder = before + along * (-mirror * 0.17);
    shoulder.y() = trip.point.y();
    const Vector3d ahead = ((trip.point - shoulder).normalized() + 0.3 * along * mirror).normalized();
    trip.pull.place = trip.point - ahead * figure.palm_reach + Vector3d(0, figure.palm_depth, 0);
    trip.pull.rotation = hand_rotation(side, ahead, -Vector3d::UnitY());
    trip.pull.swivel = uniform(random, 0.25, 0.6);
    plan.hands.push_back(trip);
  }
  // Lean as far as the arms need it.
  for (double lean = 0.06; lean < 0.8; lean += 0.04) {
    Controls c;
    c.yaw = plan.heading;
    plan.trunk.tilt = 0.5 * lean;
    plan.trunk.bend = 0.5 * lean;
    plan.trunk.twist =
        plan.hands.size() == 2 ? 0 : (plan.hands.front().side == 0 ? -0.25 : 0.25) * std::min(1.0, lean / 0.4);
    plan.trunk.shift = Vector3d(-inward.x(), 0, -inward.y()) * (0.1 * lean);
    c.tilt = plan.trunk.tilt + 0.01;
    c.bend = plan.trunk.bend;
    c.twist = plan.trunk.twist;
    c.root = Vector3d(plan.stand.x(), figure.stand_height - 0.02, plan.stand.y()) + plan.trunk.shift;
    for (int side = 0; side < 2; ++side)
      c.foot[side].ball = c.root + Vector3d(0, -figure.stand_height, 0);  // only the trunk counts here
    const Posed pose = pose_figure(figure, c);
    bool reached = true;
    for (const HandTrip& trip : plan.hands)
      reached = reached && (pose.position[16 + trip.side] - trip.pull.place).norm() < 0.95 * figure.arm();
    if (reached) return plan;
  }
  return std::nullopt;
}

}  // namespace inhabit
