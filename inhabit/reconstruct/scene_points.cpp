#include "inhabit/reconstruct/scene_points.h"

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/math/quantile.h"
#include "inhabit/math/random.h"

namespace inhabit::reconstruct {
namespace {

using Eigen::Vector3d;

constexpr size_t kMostCells = 8'000'000;

}  // namespace

size_t PointGrid::Hash::operator()(const std::array<int64_t, 3>& key) const {
  uint64_t hash = 1;
  for (const int64_t k : key) hash = item_seed(hash, static_cast<uint64_t>(k));
  return hash;
}

void PointGrid::add(const View& view, const torch::Tensor& where, const Camera& camera, const std::string& subject) {
  const auto depth = view.depth.accessor<float, 2>();
  const auto wanted = where.accessor<bool, 2>();
  const Eigen::Isometry3d& to_world = camera.pose(view.frame);
  for (int64_t row = 0; row < depth.size(0); ++row)
    for (int64_t column = 0; column < depth.size(1); ++column) {
      const double d = depth[row][column];
      if (!(d > 0) || !wanted[row][column]) continue;
      const Vector3d point = to_world * (d * camera.ray(static_cast<double>(column), static_cast<double>(row)));
      const Vector3d at = point / cell_;
      if (!(at.cwiseAbs().maxCoeff() < 1e9)) throw Error(subject, "a depth is beyond all measure");
      Cell& cell = cells_[{static_cast<int64_t>(std::floor(at.x())), static_cast<int64_t>(std::floor(at.y())),
                           static_cast<int64_t>(std::floor(at.z()))}];
      cell.sum += point;
      ++cell.count;
      if (cell.last != view.frame) ++cell.frames;
      cell.last = view.frame;
    }
  if (cells_.size() > kMostCells)
    throw Error(subject, "the scene is larger than " + std::to_string(kMostCells) + " cells of its grid");
}

std::vector<Vector3d> PointGrid::points(int64_t frames) const {
  std::vector<std::pair<std::array<int64_t, 3>, Vector3d>> kept;
  for (const auto& [key, cell] : cells_)
    if (cell.frames >= frames) kept.emplace_back(key, cell.sum / static_cast<double>(cell.count));
  // A map's order is its library's own.
  std::sort(kept.begin(), kept.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Vector3d> out;
  out.reserve(kept.size());
  for (const auto& [key, point] : kept) out.push_back(point);
  return out;
}

std::vector<Vector3d> without_seen_through(const std::vector<Vector3d>& points, const std::vector<View>& views,
                                           const Camera& camera, double margin) {
  std::vector<int> through(points.size(), 0);
  for (const View& view : views) {
    const Eigen::Isometry3d to_camera = camera.pose(view.frame).inverse();
    const auto depth = view.depth.accessor<float, 2>();
    for (size_t i = 0; i < points.size(); ++i) {
      const OnImage at = project(camera, to_camera, points[i]);
      if (!at.inside()) continue;
      // All around the pixel, so that an edge seen beside the point does not count.
      double nearest = HUGE_VAL;
      for (int64_t r = std::max<int64_t>(at.row - 1, 0); r <= std::min(at.row + 1, camera.height - 1); ++r)
        for (int64_t c = std::max<int64_t>(at.column - 1, 0); c <= std::min(at.column + 1, camera.width - 1); ++c)
          nearest = std::min(nearest, static_cast<double>(depth[r][c]));
      if (nearest > at.z * (1 + margin) + margin) ++through[i];
    }
  }
  const int most = views.size() < 2 ? 1 : 2;
  std::vector<Vector3d> out;
  for (size_t i = 0; i < points.size(); ++i)
    if (through[i] < most) out.push_back(points[i]);
  return out;
}

// Not floor_under() (scene/floor.h): points of depth maps lie above and below the floor, and mostly where no foot was.
double floor_height(const std::vector<Vector3d>& points, double expected, double reach) {
  constexpr double kLayer = 0.02;
  const auto layers = static_cast<size_t>(std::ceil(2 * reach / kLayer));
  std::vector<int> count(layers + 2, 0);
  std::vector<double> heights;
  for (const Vector3d& p : points) {
    const double up = p.y() - expected + reach;
    if (!(up >= 0 && up < 2 * reach)) continue;
    heights.push_back(p.y());
    ++count[static_cast<size_t>(up / kLayer) + 1];
  }
  if (heights.size() < 50) return expected;
  size_t fullest = 1;
  const auto filled = [&](size_t i) { return count[i - 1] + 2 * count[i] + count[i + 1]; };
  for (size_t i = 2; i <= layers; ++i)
    if (filled(i) > filled(fullest)) fullest = i;
  const double middle = expected - reach + kLayer * (static_cast<double>(fullest) - 0.5);
  std::vector<double> near;
  for (const double h : heights)
    if (std::abs(h - middle) < 1.5 * kLayer) near.push_back(h);
  if (near.size() < 50) return expected;
  return median(std::move(near));
}

Mesh floor_mesh(const std::vector<Vector3d>& points, double height) {
  Vector3d low = points.front(), high = points.front();
  for (const Vector3d& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const auto x0 = static_cast<float>(low.x() - 1), x1 = static_cast<float>(high.x() + 1),
             z0 = static_cast<float>(low.z() - 1), z1 = static_cast<float>(high.z() + 1),
             y = static_cast<float>(height);
  Mesh out;
  out.name = "floor";
  out.vertices = torch::tensor({x0, y, z0, x0, y, z1, x1, y, z1, x1, y, z0}).view({4, 3});
  out.faces = torch::tensor({0, 1, 2, 0, 2, 3}, torch::kInt64).view({2, 3});
  out.color = {0.45F, 0.40F, 0.34F};
  return out;
}

}  // namespace inhabit::reconstruct
