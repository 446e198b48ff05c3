#include "inhabit/scene/free_space.h"

#include <algorithm>

namespace inhabit {

double FreeSpace::at(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d g = (p - origin) / cell;
  if (!(g.x() >= 0 && g.y() >= 0 && g.x() <= nx - 1 && g.y() <= nz - 1)) return -kFarthest;
  const int i = std::min(static_cast<int>(g.x()), nx - 2), k = std::min(static_cast<int>(g.y()), nz - 2);
  const double u = g.x() - i, v = g.y() - k;
  const float* c = clearance.data() + static_cast<size_t>(k) * nx + i;
  return (1 - v) * ((1 - u) * c[0] + u * c[1]) + v * ((1 - u) * c[nx] + u * c[nx + 1]);
}

Eigen::Vector2d FreeSpace::away(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d dx(cell / 2, 0), dz(0, cell / 2);
  const Eigen::Vector2d gradient(at(p + dx) - at(p - dx), at(p + dz) - at(p - dz));
  const double length = gradient.norm();
  return length > 1e-6 ? Eigen::Vector2d(gradient / length) : Eigen::Vector2d::Zero();
}

}  // namespace inhabit
