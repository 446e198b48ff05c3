#include "inhabit/inbetween/learned_detours.h"

#include <algorithm>
#include <numeric>

#include "inhabit/inbetween/obstacle_detours.h"
#include "inhabit/math/random.h"

namespace inhabit::inbetween {

using Eigen::Vector2d;
using torch::Tensor;

namespace {

constexpr int64_t kPlacesChecked = 256;                   // of a path
constexpr double kLongestLine = kMapCell * kMapLong - 1;  // metres: half a metre of the map is left beyond each key
constexpr double kColdest = 1e-3;                         // temperature: only the likeliest is drawn
constexpr float kRunsInto = 0.07F;                        // metres: nearer than that somebody is in it

/// Whether a path of these sines (2, 14) is free of obstacles away from the keys, and nowhere too quick.
bool walkable(const Tensor& sines, const SceneDistances& scene, const PathLine& line, int64_t frames) {
  const Tensor length = torch::tensor(line.length(), torch::kFloat32);
  const Tensor steps = path_places(sines, torch::linspace(0, 1, frames + 1), length).diff(1, 0).norm(2, {1});
  if (steps.max().item<double>() > kQuickest) return false;
  const Tensor places = path_places(sines, torch::linspace(0, 1, kPlacesChecked), length).contiguous();  // (256, 2)
  const auto place = places.accessor<float, 2>();
  for (int64_t i = 0; i < kPlacesChecked; ++i) {
    const Vector2d at = line.world(place[i][0], place[i][1]);
    const bool near_key = std::min((at - line.from).norm(), (at - line.to).norm()) < kNearKeys;
    if (!near_key && nearest_upright(scene, at) < kRunsInto) return false;
  }
  return true;
}

/// The hypothesis that is drawn, then the others, likeliest first.
std::vector<int64_t> in_order(const Tensor& log_probability, double temperature, uint64_t seed) {
  std::vector<int64_t> order(static_cast<size_t>(log_probability.size(0)));
  std::iota(order.begin(), order.end(), 0);
  const Tensor sums = (log_probability / std::max(temperature, kColdest)).softmax(0).cumsum(0);
  std::mt19937_64 random(seed);
  const double at = uniform(random, 0, 1);
  int64_t drawn = 0;
  while (drawn + 1 < sums.size(0) && sums[drawn].item<double>() < at) ++drawn;
  const auto rank = [&](int64_t k) { return k == drawn ? 1.F : log_probability[k].item<float>(); };
  std::sort(order.begin(), order.end(), [&](int64_t a, int64_t b) { return rank(a) > rank(b); });
  return order;
}

}  // namespace

Tensor learned_detours(PathNet network, const Poses& keys, const Tensor& groups, const SceneDistances& scene,
                       double temperature, uint64_t seed, std::vector<int64_t>* unreached) {
  Tensor detours = torch::zeros({keys.frames(), 2});
  for (const RootLeg& leg : root_legs(root_places(keys), groups)) {
    const PathLine line{leg.a, leg.b};
    if (!line_blocked(scene, line)) continue;
    if (line.length() > kLongestLine) {
      if (unreached) unreached->push_back(leg.to);
      continue;
    }
    const Tensor map = path_map(scene, line);
    const ProposedPaths proposed =
        network->forward(map.unsqueeze(0), torch::tensor({static_cast<float>(line.length())}));
    const Tensor sines = proposed.rounds.back()[0];
    const std::vector<int64_t> order =
        in_order(proposed.log_probability[0], temperature, item_seed(seed, static_cast<uint64_t>(leg.to)));
    const auto taken = std::find_if(order.begin(), order.end(),
                                    [&](int64_t k) { return walkable(sines[k], scene, line, leg.to - leg.from); });
    if (taken == order.end()) {
      if (unreached) unreached->push_back(leg.to);
      continue;
    }
    const Tensor times = torch::arange(1, leg.to - leg.from, torch::kFloat32) / static_cast<double>(leg.to - leg.from);
    const Tensor offsets = path_offsets(sines[*taken], times);
    const Vector2d middle = line.world(0, 0);
    const auto offset = offsets.accessor<float, 2>();
    auto detour = detours.accessor<float, 2>();
    for (int64_t i = 0; i < offsets.size(0); ++i) {
      const Vector2d aside = line.world(offset[i][0], offset[i][1]) - middle;
      for (int axis = 0; axis < 2; ++axis) detour[leg.from + 1 + i][axis] = static_cast<float>(aside[axis]);
    }
  }
  return detours;
}

}  // namespace inhabit::inbetween
