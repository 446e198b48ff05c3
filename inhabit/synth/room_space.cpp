#include "inhabit/synth/room_space.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace inhabit {
namespace {

constexpr double kPersonHeight = 1.95;  // what hangs higher is walked under

// Distance from p to a rectangle around the origin, negative inside.
double rectangle_distance(const Eigen::Vector2d& p, const Eigen::Vector2d& half) {
  const Eigen::Vector2d d = p.cwiseAbs() - half;
  return d.cwiseMax(0).norm() + std::min(d.maxCoeff(), 0.0);
}

}  // namespace

FreeSpace free_space(const Room& room) {
  FreeSpace space;
  space.nx = std::max(2, static_cast<int>(std::floor(room.size.x() / space.cell)) + 1);
  space.nz = std::max(2, static_cast<int>(std::floor(room.size.y() / space.cell)) + 1);
  space.origin = -0.5 * space.cell * Eigen::Vector2d(space.nx - 1, space.nz - 1);
  space.clearance.resize(static_cast<size_t>(space.nx) * space.nz);
  for (int k = 0; k < space.nz; ++k)
    for (int i = 0; i < space.nx; ++i) {
      const Eigen::Vector2d to_wall = room.size / 2 - space.point(i, k).cwiseAbs();
      space.clearance[static_cast<size_t>(k) * space.nx + i] =
          static_cast<float>(std::min(to_wall.minCoeff(), FreeSpace::kFarthest));
    }
  for (const Furniture& piece : room.furniture) add_obstacle(space, piece);
  return space;
}

void add_obstacle(FreeSpace& space, const Furniture& piece) {
  struct Rectangle {
    Eigen::Vector2d center, half;
  };
  std::vector<Rectangle> rectangles;  // boxes seen from above, without those inside another
  auto covered = [](const Rectangle& a, const Rectangle& b) {
    return ((a.center - b.center).cwiseAbs() + a.half - b.half).maxCoeff() <= 1e-9;
  };
  for (const Box& box : piece.boxes) {
    if (box.center.y() - box.half.y() > kPersonHeight) continue;
    const Rectangle r{{box.center.x(), box.center.z()}, {box.half.x(), box.half.z()}};
    if (std::any_of(rectangles.begin(), rectangles.end(), [&](const Rectangle& o) { return covered(r, o); })) continue;
    std::erase_if(rectangles, [&](const Rectangle& o) { return covered(o, r); });
    rectangles.push_back(r);
  }
  if (rectangles.empty()) return;
  const Eigen::Isometry3d to_own = piece.pose.inverse();
  const Eigen::AlignedBox3d bounds = piece.bounds();
  const Eigen::Vector3d middle = piece.pose * Eigen::Vector3d(bounds.center().x(), 0, bounds.center().z());
  const double reach = Eigen::Vector2d(bounds.sizes().x(), bounds.sizes().z()).norm() / 2 + FreeSpace::kFarthest;
  const Eigen::Vector2d c(middle.x(), middle.z());
  const Eigen::Vector2d low = (c - space.origin).array() - reach, high = (c - space.origin).array() + reach;
  const int i0 = std::max(0, static_cast<int>(low.x() / space.cell)),
            i1 = std::min(space.nx - 1, static_cast<int>(high.x() / space.cell) + 1),
            k0 = std::max(0, static_cast<int>(low.y() / space.cell)),
            k1 = std::min(space.nz - 1, static_cast<int>(high.y() / space.cell) + 1);
  for (int k = k0; k <= k1; ++k)
    for (int i = i0; i <= i1; ++i) {
      const Eigen::Vector2d p = space.point(i, k);
      const Eigen::Vector3d own = to_own * Eigen::Vector3d(p.x(), 0, p.y());
      float& clearance = space.clearance[static_cast<size_t>(k) * space.nx + i];
      for (const Rectangle& r : rectangles)
        clearance = std::min(
            clearance, static_cast<float>(rectangle_distance(Eigen::Vector2d(own.x(), own.z()) - r.center, r.half)));
    }
}

std::vector<int32_t> walkable_regions(const FreeSpace& space, double radius) {
  const int n = space.nx * space.nz;
  std::vector<int32_t> region(static_cast<size_t>(n), 0);
  std::vector<int> areas, open;
  for (int seed = 0; seed < n; ++seed) {
    if (region[seed] != 0 || space.clearance[seed] < radius) continue;
    const int32_t id = static_cast<int32_t>(areas.size()) + 1;
    areas.push_back(0);
    region[seed] = id;
    open.assign(1, seed);
    while (!open.empty()) {
      const int at = open.back();
      open.pop_back();
      ++areas.back();
      const int x = at % space.nx, z = at / space.nx;
      for (const auto& [dx, dz] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        const int i = x + dx, k = z + dz, next = k * space.nx + i;
        if (i < 0 || k < 0 || i >= space.nx || k >= space.nz || region[next] != 0 || space.clearance[next] < radius)
          continue;
        region[next] = id;
        open.push_back(next);
      }
    }
  }
  std::vector<int32_t> order(areas.size()), rank(areas.size() + 1, 0);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int32_t a, int32_t b) { return areas[a] > areas[b]; });
  for (size_t i = 0; i < order.size(); ++i) rank[order[i] + 1] = static_cast<int32_t>(i) + 1;
  for (int32_t& r : region) r = rank[r];
  return region;
}

Eigen::Vector2d place_before(const Furniture& piece, const Surface& surface, double distance) {
  const Eigen::Vector3d front = surface.center + Eigen::Vector3d(0, 0, surface.half_depth + distance);
  const Eigen::Vector3d world = piece.pose * front;
  return {world.x(), world.z()};
}

}  // namespace inhabit
