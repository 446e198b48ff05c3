#include <algorithm>
#include <cmath>

#include "inhabit/synth/furniture_builder.h"

namespace inhabit {
namespace {

using furniture::Builder;
using furniture::Color;
using furniture::kFabrics;
using furniture::kSteel;
using furniture::kWoods;
using furniture::pick;

/// Two rests for the arms beside a seat of this width, each on a post.
void arms_on_posts(Builder& b, const Color& color, double w, double rear, double front, double seat, double height) {
  constexpr double kHalf = 0.032;
  for (const double s : {1.0, -1.0}) {
    const double x = s * (w / 2 + kHalf);
    b.solid(color, {x - kHalf, height - 0.03, rear}, {x + kHalf, height, front}, 0.01, 2);
    b.solid(color, {x - 0.015, seat - 0.05, rear + 0.08}, {x + 0.015, height - 0.03, rear + 0.14});
    b.surface(s > 0 ? Surface::Kind::arm_rest_left : Surface::Kind::arm_rest_right, x - kHalf + 0.01, x + kHalf - 0.01,
              rear + 0.02, front - 0.01, height);
  }
}

/// A column on five feet with castors that do not reach out from under the seat.
void star_base(Builder& b, double reach, double column, double foot, double top) {
  b.leg(kSteel, 0, 0, top, column, true);
  for (int i = 0; i < 5; ++i) {
    const double angle = 2 * M_PI * (i + 0.5) / 5, x = reach * std::sin(angle), z = reach * std::cos(angle);
    for (const double at : {0.35, 0.7})
      b.solid(kSteel, {at * x - 0.03, foot, at * z - 0.03}, {at * x + 0.03, foot + 0.03, at * z + 0.03});
    b.solid(kSteel, {x - 0.025, 0, z - 0.025}, {x + 0.025, foot + 0.02, z + 0.025}, 0.012, 2);
  }
}

}  // namespace

Furniture make_office_chair(std::mt19937_64& random, double height) {
  Builder b("office_chair");
  const Color& fabric = pick(random, kFabrics);
  const double w = uniform(random, 0.44, 0.52), d = uniform(random, 0.43, 0.50), thick = uniform(random, 0.05, 0.10);
  b.solid(fabric, {-w / 2, height - thick, -d / 2}, {w / 2, height, d / 2}, 0.025, 2);
  star_base(b, 0.5 * std::min(w, d) - 0.02, uniform(random, 0.025, 0.04), uniform(random, 0.05, 0.09), height - thick);
  const double top = height + uniform(random, 0.40, 0.62), half = 0.5 * w * uniform(random, 0.75, 1);
  const double rear = -d / 2, z = rear + uniform(random, 0.03, 0.05);
  b.solid(kSteel, {-0.03, height - 0.04, rear - 0.03}, {0.03, top - 0.1, rear});
  b.solid(fabric, {-half, height + uniform(random, 0.06, 0.16), rear}, {half, top, z}, 0.015, 2);
  if (chance(random, 0.4)) b.solid(fabric, {-0.12, top + 0.05, rear}, {0.12, top + 0.18, z}, 0.015, 2);
  b.surface(Surface::Kind::seat, -w / 2 + 0.02, w / 2 - 0.02, z, d / 2, height);
  if (chance(random, 0.6))
    arms_on_posts(b, kSteel, w, z, d / 2 - uniform(random, 0.08, 0.16), height, height + uniform(random, 0.18, 0.25));
  b.back(top, z);
  return b.finish();
}

Furniture make_solid_chair(std::mt19937_64& random, double height) {
  Builder b("solid_chair");
  const Color& color = chance(random, 0.5) ? pick(random, kFabrics) : pick(random, kWoods);
  const double w = uniform(random, 0.38, 0.50), d = uniform(random, 0.42, 0.48), thick = uniform(random, 0.03, 0.08);
  const double rear = -d / 2, back = uniform(random, 0.04, 0.2), aside = uniform(random, 0, 0.09);
  b.solid(color, {-w / 2, height - thick, rear}, {w / 2, height, d / 2}, 0.015, 2);
  b.solid(color, {-w / 2 + aside, 0, rear}, {w / 2 - aside, height - thick, d / 2 - uniform(random, 0.06, 0.14)}, 0.02,
          2);
  const double top = height + uniform(random, 0.32, 0.46);
  b.solid(color, {-w / 2, chance(random, 0.5) ? 0 : height, rear - back}, {w / 2, top, rear}, 0.02, 2);
  b.surface(Surface::Kind::seat, -w / 2 + 0.02, w / 2 - 0.02, rear, d / 2, height);
  b.back(top, rear);
  return b.finish();
}

}  // namespace inhabit
