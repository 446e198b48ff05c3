#include "inhabit/math/furthest_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "inhabit/error.h"

namespace inhabit {

torch::Tensor furthest_point_indices(const torch::Tensor& points, int64_t count, int64_t first) {
  const int64_t n = points.size(0);
  if (count > n) throw Error(fmt::format("{} points cannot be chosen from {}", count, n));
  const torch::Tensor contiguous = points.to(torch::kFloat32).contiguous();
  const float* p = contiguous.data_ptr<float>();
  torch::Tensor chosen = torch::empty({count}, torch::kInt64);
  std::vector<float> distance(static_cast<size_t>(n), HUGE_VALF);  // squared, to the nearest chosen point
  int64_t next = first;
  for (int64_t k = 0; k < count; ++k) {
    chosen[k] = next;
    const float x = p[3 * next], y = p[3 * next + 1], z = p[3 * next + 2];
    for (int64_t i = 0; i < n; ++i) {
      const float dx = p[3 * i] - x, dy = p[3 * i + 1] - y, dz = p[3 * i + 2] - z;
      const auto at = static_cast<size_t>(i);
      distance[at] = std::min(distance[at], dx * dx + dy * dy + dz * dz);
    }
    next = std::max_element(distance.begin(), distance.end()) - distance.begin();
  }
  return chosen;
}

}  // namespace inhabit
