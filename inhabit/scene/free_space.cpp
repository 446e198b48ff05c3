#include "inhabit/scene/free_space.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <utility>

#include "inhabit/error.h"
#include "inhabit/math/heading.h"

namespace inhabit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kStep = 0.05, kPersonHeight = 1.95;  // metres over the floor: stepped over, walked under
constexpr double kLongest = 200;                      // metres of a grid's side

/// The part of a polygon on one side of the plane y = height.
std::vector<Vector3d> clipped(const std::vector<Vector3d>& polygon, double height, bool above) {
  std::vector<Vector3d> out;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vector3d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double from = above ? a.y() - height : height - a.y(), to = above ? b.y() - height : height - b.y();
    if (from >= 0) out.push_back(a);
    if ((from < 0) != (to < 0)) out.emplace_back(a + (b - a) * (from / (from - to)));
  }
  return out;
}

/// The point of a convex polygon that is nearest to p.
Vector2d nearest_in(const std::vector<Vector2d>& polygon, const Vector2d& p) {
  Vector2d nearest = polygon.front();
  double area = 0;  // twice that; none of a wall's, seen from above
  bool left = true, right = true;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d& a = polygon[i];
    const Vector2d side = polygon[(i + 1) % polygon.size()] - a, to = p - a;
    const double cross = side.x() * to.y() - side.y() * to.x();
    area += cross;
    left = left && cross >= 0;
    right = right && cross <= 0;
    const double along = side.squaredNorm() > 0 ? std::clamp(side.dot(to) / side.squaredNorm(), 0.0, 1.0) : 0;
    const Vector2d q = a + along * side;
    if ((q - p).squaredNorm() < (nearest - p).squaredNorm()) nearest = q;
  }
  return std::abs(area) > 1e-9 && (left || right) ? p : nearest;
}

/// What stands on a floor, seen from above: convex polygons.
std::vector<std::vector<Vector2d>> outlines_of(const Scene& obstacles) {
  std::vector<std::vector<Vector2d>> out;
  for (const Mesh& mesh : obstacles.meshes) {
    if (mesh.faces.numel() == 0) continue;
    const torch::Tensor vertices = mesh.vertices.to(torch::kFloat64).contiguous(),
                        faces = mesh.faces.to(torch::kInt64).contiguous();
    const auto v = vertices.accessor<double, 2>();
    const auto f = faces.accessor<int64_t, 2>();
    for (int64_t i = 0; i < f.size(0); ++i) {
      std::vector<Vector3d> part;
      for (int64_t k = 0; k < 3; ++k) part.emplace_back(v[f[i][k]][0], v[f[i][k]][1], v[f[i][k]][2]);
      part = clipped(clipped(part, kStep, true), kPersonHeight, false);
      if (part.empty()) continue;
      std::vector<Vector2d> outline;
      outline.reserve(part.size());
      for (const Vector3d& p : part) outline.push_back(on_ground(p));
      out.push_back(std::move(outline));
    }
  }
  return out;
}

/// Distances from the grid points next to obstacles go on to their neighbours with the place they were measured to.
class Brushfire {
 public:
  explicit Brushfire(FreeSpace& space) : space_(space), source_(space.clearance.size()) {}

  void kindle(const std::vector<Vector2d>& outline) {
    Eigen::AlignedBox2d box;
    for (const Vector2d& p : outline) box.extend(p);
    const Vector2d low = (box.min() - space_.origin) / space_.cell, high = (box.max() - space_.origin) / space_.cell;
    const int i0 = std::max(0, static_cast<int>(low.x()) - 1), k0 = std::max(0, static_cast<int>(low.y()) - 1);
    const int i1 = std::min(space_.nx - 1, static_cast<int>(high.x()) + 2),
              k1 = std::min(space_.nz - 1, static_cast<int>(high.y()) + 2);
    for (int k = k0; k <= k1; ++k)
      for (int i = i0; i <= i1; ++i) reach(i, k, nearest_in(outline, space_.point(i, k)));
  }

  void spread() {
    while (!queue_.empty()) {
      const auto [far, cell] = queue_.top();
      queue_.pop();
      if (far > space_.clearance[cell]) continue;
      const int i = static_cast<int>(cell) % space_.nx, k = static_cast<int>(cell) / space_.nx;
      for (int di = -1; di <= 1; ++di)
        for (int dk = -1; dk <= 1; ++dk)
          if (i + di >= 0 && k + dk >= 0 && i + di < space_.nx && k + dk < space_.nz)
            reach(i + di, k + dk, source_[cell]);
    }
  }

 private:
  void reach(int i, int k, const Vector2d& source) {
    const size_t cell = static_cast<size_t>(k) * static_cast<size_t>(space_.nx) + static_cast<size_t>(i);
    const auto far = static_cast<float>((space_.point(i, k) - source).norm());
    if (far >= space_.clearance[cell]) return;
    space_.clearance[cell] = far;
    source_[cell] = source;
    queue_.emplace(far, cell);
  }

  FreeSpace& space_;
  std::vector<Vector2d> source_;
  using Entry = std::pair<float, size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

}  // namespace

FreeSpace free_space(const Scene& obstacles, double beyond, const Eigen::AlignedBox2d& also) {
  const std::vector<std::vector<Vector2d>> outlines = outlines_of(obstacles);
  Eigen::AlignedBox2d box = also;
  for (const auto& outline : outlines)
    for (const Vector2d& p : outline) box.extend(p);
  if (box.isEmpty()) box.extend(Vector2d(0, 0));
  FreeSpace space;
  space.origin = box.min() - Vector2d::Constant(beyond);
  const Vector2d size = box.sizes() + Vector2d::Constant(2 * beyond);
  if (!(size.maxCoeff() <= kLongest))
    throw Error(obstacles.name.empty() ? "scene" : obstacles.name, "is over 200 m wide: no path is found in it");
  space.nx = std::max(2, static_cast<int>(std::ceil(size.x() / space.cell)) + 1);
  space.nz = std::max(2, static_cast<int>(std::ceil(size.y() / space.cell)) + 1);
  space.clearance.assign(static_cast<size_t>(space.nx) * static_cast<size_t>(space.nz),
                         static_cast<float>(FreeSpace::kFarthest));
  Brushfire fire(space);
  for (const auto& outline : outlines) fire.kindle(outline);
  fire.spread();
  return space;
}

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
