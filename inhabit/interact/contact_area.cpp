#include "inhabit/interact/contact_area.h"

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/interact/seat_map.h"
#include "inhabit/math/heading.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Where on a chair, in the axes of its seat: metres to the side of the hand, ahead, and over the seat.
struct Part {
  const char* name;
  Vector2d aside, ahead, over;  ///< from, to
  Vector2d best;                ///< aside and ahead: the nearest place to this is taken
};

// A pelvis rests some 0.2 m behind the front edge; shoulders are 0.2 m off the middle.
constexpr double kSeatLevel = 0.05;

const std::vector<Part>& parts() {
  static const std::vector<Part> all = {
      {"armrest", {0.16, 0.7}, {-0.25, 0.4}, {0.08, 0.4}, {0.27, 0.1}},
      {"front", {0.05, 0.4}, {0.1, 0.5}, {-kSeatLevel, kSeatLevel}, {0.2, 0.5}},
      {"side", {0.12, 0.6}, {-0.2, 0.2}, {-kSeatLevel, kSeatLevel}, {0.6, 0.0}},
      {"back", {0.02, 0.4}, {-0.7, -0.08}, {0.2, 0.9}, {0.16, -0.1}},
  };
  return all;
}

}  // namespace

const std::vector<std::string>& contact_areas() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    out.reserve(parts().size());
    for (const Part& part : parts()) out.emplace_back(part.name);
    return out;
  }();
  return names;
}

Vector3d contact_on(const Chair& chair, const std::string& area, int side) {
  const auto part = std::find_if(parts().begin(), parts().end(), [&](const Part& p) { return area == p.name; });
  if (part == parts().end()) {
    std::string names;
    for (const std::string& name : contact_areas()) names += (names.empty() ? "" : ", ") + name;
    throw Error(chair.name, "'" + area + "' is no part of a chair; there are " + names);
  }
  const TopView view = view_from_above(chair.mesh);
  const Vector2d middle = on_ground(chair.seat()), ahead = ahead_of(chair.heading()),
                 out = (side == 0 ? 1 : -1) * left_of(chair.heading());
  std::optional<Vector3d> best;
  double least = HUGE_VAL;
  const auto within = [](double x, const Vector2d& range) { return x >= range[0] && x <= range[1]; };
  for (int iz = 0; iz < view.nz; ++iz)
    for (int ix = 0; ix < view.nx; ++ix) {
      const double height = view.height[view.at(ix, iz)];
      if (height < 0) continue;
      const Vector2d p = view.point(ix, iz), off = p - middle;
      const double x = off.dot(out), z = off.dot(ahead);
      if (!within(x, part->aside) || !within(z, part->ahead) || !within(height - chair.seat_height, part->over))
        continue;
      const double far = (Vector2d(x, z) - part->best).norm();
      if (far < least) {
        least = far;
        best = {p.x(), view.floor + height, p.y()};
      }
    }
  if (!best) throw Error(chair.name, "has no " + area + " on the " + (side == 0 ? "left" : "right"));
  return *best;
}

std::optional<Vector3d> contact_at(const Chair& chair, const ContactPlace& place, int side) {
  if (const auto* point = std::get_if<Vector3d>(&place)) return *point;
  const auto* area = std::get_if<std::string>(&place);
  if (area == nullptr || *area == "none") return std::nullopt;
  return contact_on(chair, *area, side);
}

}  // namespace inhabit::interact
