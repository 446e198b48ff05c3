#include "inhabit/interact/sense_noise.h"

#include "inhabit/math/random.h"

namespace inhabit::interact {

SenseNoise::SenseNoise(const InputLayout& layout, const Config& config, double probability, std::mt19937_64& random) {
  if (!chance(random, probability)) return;
  const auto disturb = [&](int64_t place, double emptied, double filled) {
    if (chance(random, emptied)) {
      numbers_.emplace_back(place, 0.F);
    } else if (chance(random, filled)) {
      numbers_.emplace_back(place, static_cast<float>(uniform(random, 0, 1)));
    }
  };
  const double emptied = uniform(random, 0, 0.6), filled = uniform(random, 0, 0.1);
  const double around_emptied = uniform(random, 0, 0.3), around_filled = uniform(random, 0, 0.03);
  for (int64_t i = layout.ego.first; i < layout.ego.end(); ++i) disturb(i, around_emptied, around_filled);
  const int64_t voxels = layout.chair.size / 4, layer = voxels / config.chair_grid;
  for (int64_t i = 0; i < voxels; ++i) disturb(layout.chair.first + 4 * i + 3, emptied, filled);
  if (!chance(random, 0.3)) return;
  // What carries the seat: legs, a column or a closed body.
  const auto value = static_cast<float>(chance(random, 0.5) ? uniform(random, 0.5, 1) : 0);
  const int64_t layers = uniform_int(random, 1, std::max(1, (3 * config.chair_grid) / 8));
  for (int64_t i = 0; i < layers * layer; ++i) numbers_.emplace_back(layout.chair.first + 4 * i + 3, value);
}

void SenseNoise::apply(float* row) const {
  for (const auto& [place, value] : numbers_) row[place] = value;
}

}  // namespace inhabit::interact
