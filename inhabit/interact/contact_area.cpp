#include "inhabit/interact/contact_area.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "inhabit/error.h"
#include "inhabit/interact/seat_map.h"
#include "inhabit/math/heading.h"
#include "inhabit/scene/point_rows.h"
#include "inhabit/scene/query.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Where on a chair, in the axes of its seat: metres to the side of the hand, ahead, and over the seat.
struct Part {
  Vector2d aside, ahead, over;  ///< from, to
  Vector2d best;                ///< aside and ahead: the nearest place to this is taken
};

constexpr double kSeatLevel = 0.05, kLevel = 0.03;  // metres: with the rounded edges of cushions, and without

// A pelvis rests some 0.2 m behind the front edge. The places are the middle of those where people of the training data
// take hold of each part: what they never do the networks do badly. What is as high as an arm rest but farther back may
// be the back rest.
const Part kArmRestPart = {{0.16, 0.7}, {0, 0.4}, {0.08, 0.4}, {0.27, 0.28}},
           kFrontPart = {{0.05, 0.4}, {0.1, 0.5}, {-kSeatLevel, kSeatLevel}, {0.29, 0.5}},
           kSidePart = {{0.12, 0.6}, {-0.2, 0.2}, {-kLevel, kLevel}, {0.3, 0.08}};

/// The place of a part that is nearest to where it is best taken hold of by the left (0) or right (1) hand, world;
/// nothing where there is none.
std::optional<Vector3d> nearest_of(const Part& part, const Chair& chair, int side) {
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
      if (!within(x, part.aside) || !within(z, part.ahead) || !within(height - chair.seat_height, part.over)) continue;
      const double far = (Vector2d(x, z) - part.best).norm();
      if (far < least) {
        least = far;
        best = {p.x(), view.floor + height, p.y()};
      }
    }
  return best;
}

/// Where a hand takes hold of the side of the back rest: its front edge, some 0.18 m over the seat. Nothing where there
/// is none, where it is out of reach, or behind an arm rest. (The top of a back rest behind oneself is out of reach.)
std::optional<Vector3d> side_of_back(const Chair& chair, int side) {
  if (nearest_of(kArmRestPart, chair, side)) return {};
  constexpr double kOutside = 12, kFarthest = 0.4, kNearest = 0.1;  // metres aside; meshes are 10 m wide
  constexpr double kBegins = -0.08, kEnds = -0.5, kStep = 0.02, kBehindFace = 0.016;  // metres ahead
  const SceneQuery query(Scene{chair.name, {chair.mesh}, {}});
  const double mirror = side == 0 ? 1 : -1;
  const torch::Tensor inwards = point_rows({chair.frame.linear() * Vector3d(-mirror, 0, 0)});
  for (const double over : {0.18, 0.22, 0.26, 0.14}) {
    const auto edge_at = [&](double ahead) -> std::optional<Vector3d> {
      const Vector3d from(mirror * kOutside, chair.seat_height + over, ahead);
      const RayHits hits = query.cast(point_rows({chair.frame * from}), inwards);
      if (!hits.hit.item<bool>()) return {};
      const Vector3d edge = row_point(hits.points, 0);
      const double aside = mirror * (chair.frame.inverse() * edge).x();
      return aside >= kNearest && aside <= kFarthest ? std::optional(edge) : std::nullopt;
    };
    for (double ahead = kBegins; ahead > kEnds; ahead -= kStep)
      if (const auto face = edge_at(ahead)) {
        const auto edge = edge_at(ahead - kBehindFace);
        return edge ? edge : face;
      }
  }
  return {};
}

/// A part of a chair that hands are sent to.
struct Area {
  std::string name;     ///< that it is asked for by
  std::string missing;  ///< what a chair without it has none of
  std::function<std::optional<Vector3d>(const Chair&, int)> place;
};

const std::vector<Area>& areas() {
  const auto nearest = [](const Part& part) {
    return [&part](const Chair& chair, int side) { return nearest_of(part, chair, side); };
  };
  static const std::vector<Area> all = {{"armrest", "armrest", nearest(kArmRestPart)},
                                        {"front", "front", nearest(kFrontPart)},
                                        {"side", "side", nearest(kSidePart)},
                                        {"back", "back within reach", side_of_back}};
  return all;
}

}  // namespace

const std::vector<std::string>& contact_areas() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    out.reserve(areas().size());
    for (const Area& area : areas()) out.push_back(area.name);
    return out;
  }();
  return names;
}

Vector3d contact_on(const Chair& chair, const std::string& area, int side) {
  const auto asked = std::find_if(areas().begin(), areas().end(), [&](const Area& a) { return area == a.name; });
  if (asked == areas().end()) {
    std::string names;
    for (const std::string& name : contact_areas()) names += (names.empty() ? "" : ", ") + name;
    throw Error(chair.name, "'" + area + "' is no part of a chair; there are " + names);
  }
  const std::optional<Vector3d> place = asked->place(chair, side);
  if (!place) throw Error(chair.name, "has no " + asked->missing + " on the " + (side == 0 ? "left" : "right"));
  return *place;
}

std::optional<Vector3d> contact_at(const Chair& chair, const ContactPlace& place, int side) {
  if (const auto* point = std::get_if<Vector3d>(&place)) return *point;
  const auto* area = std::get_if<std::string>(&place);
  if (area == nullptr || *area == "none") return std::nullopt;
  return contact_on(chair, *area, side);
}

}  // namespace inhabit::interact
