#include "inhabit/interact/standing_place.h"

#include <cmath>

#include "inhabit/error.h"
#include "inhabit/interact/live_person.h"
#include "inhabit/interact/route.h"
#include "inhabit/interact/voxels.h"
#include "inhabit/math/heading.h"
#include "inhabit/scene/floor.h"

namespace inhabit::interact {
namespace {

constexpr float kAboutShoulders = 0.28F;  // metres that a standing person needs about them

}  // namespace

bool room_to_stand(const Surroundings& around, const Eigen::Vector2d& place) {
  for (const float height : {0.2F, 0.6F, 1.0F, 1.4F})
    if (around.distance({static_cast<float>(place.x()), height, static_cast<float>(place.y())}, kAboutShoulders) <
        kAboutShoulders)
      return false;
  return true;
}

std::optional<Eigen::Vector2d> nearest_free(const Eigen::Vector2d& wanted,
                                            const std::function<bool(const Eigen::Vector2d&)>& free) {
  for (double radius = 0; radius < 12; radius += 0.2) {
    const int steps = std::max(1, static_cast<int>(radius * 15));
    for (int i = 0; i < steps; ++i) {
      const Eigen::Vector2d place = wanted + radius * ahead_of(2 * M_PI * i / steps);
      if (free(place)) return place;
    }
  }
  return std::nullopt;
}

Clip standing_before(const Chair& chair, const Scene& scene) {
  constexpr double kBefore = 2;  // metres
  const Surroundings around(raised(scene, -chair.frame.translation().y()));
  const Eigen::Vector2d seat = on_ground(chair.seat());
  const auto place = nearest_free(seat + kBefore * ahead_of(chair.heading()), [&](const Eigen::Vector2d& at) {
    return room_to_stand(around, at) && find_route(around.floor(), at, chair);
  });
  if (!place) throw Error(chair.name, "has no free floor near it to start from");
  Clip out = standing_clip(*place, heading_of(seat - *place));
  const auto floor = static_cast<float>(chair.frame.translation().y());
  out.trans.select(1, 1).add_(floor);
  out.joints.select(2, 1).add_(floor);
  return out;
}

}  // namespace inhabit::interact
