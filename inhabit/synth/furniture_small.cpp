#include <algorithm>

#include "inhabit/math/random.h"
#include "inhabit/synth/furniture.h"
#include "inhabit/synth/furniture_builder.h"

namespace inhabit {

// Pieces that have no front, and that nobody uses.

Furniture make_post(std::mt19937_64& random) {
  furniture::Builder b("post");
  const furniture::Color& color = chance(random, 0.5) ? furniture::kSteel : furniture::pick(random, furniture::kWoods);
  const double half = uniform(random, 0.02, 0.05), height = uniform(random, 1.0, 2.0);
  b.leg(color, 0, 0, height, half, chance(random, 0.5));
  if (chance(random, 0.6)) {  // a foot plate, as of lamps and coat stands
    const double plate = uniform(random, 0.07, 0.14);
    b.solid(color, {-plate, 0, -plate}, {plate, 0.02, plate});
  }
  if (chance(random, 0.5)) {  // a shade
    const double shade = uniform(random, 0.08, 0.16);
    b.solid(furniture::kLinen, {-shade, height, -shade}, {shade, height + uniform(random, 0.15, 0.28), shade}, 0.02, 2);
  }
  return b.finish();
}

Furniture make_plant(std::mt19937_64& random) {
  furniture::Builder b("plant");
  const furniture::Color leaves = {0.10F, 0.24F, 0.08F};
  const double pot = uniform(random, 0.09, 0.18), rim = uniform(random, 0.22, 0.42);
  b.solid(furniture::pick(random, furniture::kFabrics), {-pot, 0, -pot}, {pot, rim, pot}, 0.02, 2);
  const double half = std::max(pot, uniform(random, 0.10, 0.26)), stem = rim + uniform(random, 0, 0.25);
  const double top = stem + uniform(random, 0.25, 0.9);
  if (stem > rim) b.leg(leaves, 0, 0, stem, 0.02, true);
  b.solid(leaves, {-half, stem, -half}, {half, top, half}, 0.08, 3);
  return b.finish();
}

Furniture make_box(std::mt19937_64& random) {
  furniture::Builder b("box");
  const double x = uniform(random, 0.12, 0.32), z = uniform(random, 0.12, 0.32), height = uniform(random, 0.2, 0.75);
  b.solid(furniture::pick(random, furniture::kWoods), {-x, 0, -z}, {x, height, z}, 0.01, 2);
  return b.finish();
}

Furniture make_screen(std::mt19937_64& random) {
  furniture::Builder b("screen");
  const double x = uniform(random, 0.3, 0.75), z = uniform(random, 0.02, 0.08), height = uniform(random, 1.4, 2.1);
  const furniture::Color& color = chance(random, 0.5) ? furniture::pick(random, furniture::kWoods) : furniture::kLinen;
  b.solid(color, {-x, 0, -z}, {x, height, z}, 0.004);
  return b.finish();
}

}  // namespace inhabit
