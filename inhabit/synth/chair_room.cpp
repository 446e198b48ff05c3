#include <algorithm>
#include <cmath>

#include "inhabit/math/heading.h"
#include "inhabit/math/random.h"
#include "inhabit/synth/chairs.h"
#include "inhabit/synth/room_space.h"

namespace inhabit {
namespace {

constexpr double kFloor = 13;  // metres on a side: starts 5 m from the chair, with room to go around

/// A piece in the way, 1.3 to 3.2 m from the chair, that leaves the place before it free.
void add_obstacle_near(Room& room, std::mt19937_64& random) {
  const Furniture& chair = room.furniture.front();
  for (int attempt = 0; attempt < 30; ++attempt) {
    Furniture piece = chance(random, 0.5)
                          ? make_table(random, uniform(random, 0.5, 1.2), uniform(random, 0.45, 0.7),
                                       chance(random, 0.5) ? uniform(random, 0.4, 0.5) : uniform(random, 0.7, 0.76))
                      : chance(random, 0.5) ? make_stool(random)
                                            : make_shelf(random);
    const Eigen::Vector3d at = chair.pose.translation();
    const double angle = uniform(random, -M_PI, M_PI), far = uniform(random, 1.3, 3.2);
    piece.place(at.x() + far * std::sin(angle), at.z() + far * std::cos(angle), uniform(random, -M_PI, M_PI));
    FreeSpace space = free_space(room);
    // Somebody can pass between it and what stands there.
    const Eigen::AlignedBox3d bounds = piece.bounds();
    double gap = 1;
    for (const double x : {-1.0, 0.0, 1.0})
      for (const double z : {-1.0, 0.0, 1.0}) {
        const Eigen::Vector3d own(x * bounds.max().x(), 0, z * bounds.max().z());
        gap = std::min(gap, space.at(on_ground(piece.pose * own)));
      }
    if (gap < 0.9) continue;
    Room with = room;
    with.furniture.push_back(piece);
    space = free_space(with);
    bool free = true;
    for (const Surface& s : chair.surfaces)
      if (s.kind == Surface::Kind::seat) free = free && walkable(space, place_before(chair, s, 0.55), 0.5);
    if (!free) continue;
    room = std::move(with);
    return;
  }
}

}  // namespace

Furniture draw_chair(std::mt19937_64& random) {
  const double draw = uniform(random, 0, 1);
  // Seats of ordinary heights, some low and some high.
  const auto height = [&](double low, double high) { return uniform(random, low, high); };
  Furniture chair = draw < 0.26   ? make_chair(random, height(0.38, 0.55))
                    : draw < 0.50 ? make_armchair(random, height(0.38, 0.52))
                    : draw < 0.63 ? make_stool(random, height(0.39, 0.55))
                    : draw < 0.73 ? make_sofa(random, uniform_int(random, 1, 3), height(0.33, 0.47))
                    : draw < 0.77 ? make_bed(random, height(0.36, 0.52))
                    : draw < 0.90 ? make_office_chair(random, height(0.40, 0.55))
                                  : make_solid_chair(random, height(0.38, 0.52));
  chair.rescale({uniform(random, chair.kind == "stool" ? 1.0 : 0.94, 1.12), 1, uniform(random, 0.94, 1.08)});
  return chair;
}

const std::vector<std::string>& chair_kinds() {
  static const std::vector<std::string> kinds = {"chair", "armchair",     "stool",      "sofa",
                                                 "bed",   "office_chair", "solid_chair"};
  return kinds;
}

Room make_chair_room(std::mt19937_64& random, const std::vector<std::string>& kinds) {
  Room room;
  room.size = {kFloor, kFloor};
  paint(room, random);
  Furniture chair = draw_chair(random);
  while (!kinds.empty() && std::find(kinds.begin(), kinds.end(), chair.kind) == kinds.end()) chair = draw_chair(random);
  chair.place(uniform(random, -0.4, 0.4), uniform(random, -0.4, 0.4), uniform(random, -M_PI, M_PI));
  room.furniture.push_back(std::move(chair));
  if (chance(random, 1.0 / 3))
    for (int i = uniform_int(random, 1, 2); i > 0; --i) add_obstacle_near(room, random);
  return room;
}

}  // namespace inhabit
