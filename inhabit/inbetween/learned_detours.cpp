#include "inhabit/inbetween/learned_detours.h"

#include <algorithm>
#include <numeric>

#include "inhabit/inbetween/obstacle_detours.h"
#include "inhabit/math/random.h"

namespace inhabit::inbetween {

using torch::Tensor;

namespace {

constexpr int64_t kPlacesChecked = 256;  // points of a path: 2 cm apart

/// Whether each of the paths (4, 2, 14) is free of obstacles away from its ends, and nowhere too quick.
std::vector<char> walkable(const Tensor& sines, const Tensor& map, const PathLine& line, int64_t frames) {
  const auto places = [&](const Tensor& shares) {  // (4, S, 2)
    const Tensor along = (shares - 0.5) * line.length();
    return path_offsets(sines, shares) + torch::stack({along, torch::zeros_like(along)}, 1);
  };
  const Tensor shares = torch::linspace(0, 1, kPlacesChecked);
  const Tensor inner = torch::minimum(shares, 1 - shares) * line.length() > kNearKeys;
  const Tensor clear =
      at_places(map.view({1, 1, kMapWide, kMapLong}), places(shares).unsqueeze(0)).view({-1, kPlacesChecked});
  const Tensor steps = places(torch::linspace(0, 1, frames + 1)).diff(1, 1).norm(2, {2});
  std::vector<char> out;
  for (int64_t k = 0; k < sines.size(0); ++k)
    out.push_back(clear[k].masked_select(inner).min().item<float>() > 0 && steps[k].max().item<double>() <= kQuickest);
  return out;
}

/// The hypothesis that is drawn, then the others, likeliest first.
std::vector<int64_t> in_order(const Tensor& log_probability, uint64_t seed) {
  std::vector<int64_t> order(static_cast<size_t>(log_probability.size(0)));
  std::iota(order.begin(), order.end(), 0);
  const Tensor sums = log_probability.exp().cumsum(0);
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
                       uint64_t seed, std::vector<int64_t>* unreached) {
  const int64_t frames = keys.frames();
  Tensor root = torch::empty({frames, 3}), detours = torch::zeros({frames, 2});
  for (int64_t t = 0; t < frames; ++t)
    for (int axis = 0; axis < 3; ++axis) root[t][axis] = keys.root(t)[axis];
  for (const RootLeg& leg : root_legs(root, groups)) {
    const PathLine line{leg.a, leg.b};
    if (line.length() > kMapCell * kMapLong - 1 || !line_blocked(scene, line)) continue;
    const Tensor map = path_map(scene, line);
    const ProposedPaths proposed =
        network->forward(map.unsqueeze(0), torch::tensor({static_cast<float>(line.length())}));
    const Tensor sines = proposed.rounds.back()[0];
    const std::vector<char> good = walkable(sines, map, line, leg.to - leg.from);
    const std::vector<int64_t> order =
        in_order(proposed.log_probability[0], item_seed(seed, static_cast<uint64_t>(leg.to)));
    const auto taken =
        std::find_if(order.begin(), order.end(), [&](int64_t k) { return good[static_cast<size_t>(k)] != 0; });
    if (taken == order.end()) {
      if (unreached) unreached->push_back(leg.to);
      continue;
    }
    const Tensor shares = torch::arange(1, leg.to - leg.from, torch::kFloat32) / static_cast<double>(leg.to - leg.from);
    const Tensor offsets = path_offsets(sines[*taken], shares);
    const Eigen::Vector2d middle = line.world(0, 0);
    const auto offset = offsets.accessor<float, 2>();
    auto detour = detours.accessor<float, 2>();
    for (int64_t i = 0; i < offsets.size(0); ++i) {
      const Eigen::Vector2d aside = line.world(offset[i][0], offset[i][1]) - middle;
      for (int axis = 0; axis < 2; ++axis) detour[leg.from + 1 + i][axis] = static_cast<float>(aside[axis]);
    }
  }
  return detours;
}

}  // namespace inhabit::inbetween
