#include "inhabit/inbetween/walked_detours.h"

#include <algorithm>
#include <vector>

#include "inhabit/inbetween/obstacle_detours.h"
#include "inhabit/inbetween/path_net.h"

namespace inhabit::inbetween {

using Eigen::Vector2d;
using torch::Tensor;

namespace {
constexpr int64_t kHalfSway = 15;  // frames: half a second, a step
}  // namespace

Tensor walked_detours(const Poses& truth, const Tensor& groups, const SceneDistances& scene) {
  Tensor out = torch::zeros({truth.frames(), 2});
  auto detour = out.accessor<float, 2>();
  for (const RootLeg& leg : root_legs(root_places(truth), groups)) {
    if (!line_blocked(scene, {leg.a, leg.b})) continue;
    const auto at = [&](int64_t t) -> Vector2d {
      const Eigen::Vector3f& root = truth.root(std::clamp(t, leg.from, leg.to));
      return {root.x(), root.z()};
    };
    const auto reflected = [&](int64_t t) -> Vector2d {
      if (t < leg.from) return 2 * leg.a - at(2 * leg.from - t);
      if (t > leg.to) return 2 * leg.b - at(2 * leg.to - t);
      return at(t);
    };
    std::vector<Vector2d> places;
    std::vector<double> gone = {0};  // metres
    for (int64_t t = leg.from; t <= leg.to; ++t) {
      // Over a second, without the sway of steps, which tells of the feet; beyond a key as if reflected in it.
      Vector2d sum = Vector2d::Zero();
      for (int64_t near = t - kHalfSway; near <= t + kHalfSway; ++near) sum += reflected(near);
      places.emplace_back(sum / static_cast<double>(2 * kHalfSway + 1));
      if (places.size() > 1) gone.push_back(gone.back() + (places.back() - places[places.size() - 2]).norm());
    }
    size_t k = 0;
    for (int64_t t = leg.from + 1; t < leg.to; ++t) {
      const double part = static_cast<double>(t - leg.from) / static_cast<double>(leg.to - leg.from);
      while (k + 2 < gone.size() && gone[k + 1] < part * gone.back()) ++k;
      const double step = gone[k + 1] - gone[k], on = step > 0 ? (part * gone.back() - gone[k]) / step : 0;
      const Vector2d aside = places[k] + on * (places[k + 1] - places[k]) - (leg.a + part * (leg.b - leg.a));
      for (int axis = 0; axis < 2; ++axis) detour[t][axis] = static_cast<float>(aside[axis]);
    }
  }
  return out;
}

}  // namespace inhabit::inbetween
