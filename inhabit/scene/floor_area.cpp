#include "inhabit/scene/floor_area.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "inhabit/scene/bounding_box.h"

namespace inhabit {
namespace {

using Eigen::Vector2d;

constexpr double kLevel = 0.1;  // metres above and below y = 0
constexpr double kFar = 50;     // metres from a person to what is looked at
constexpr double kHole = 0.5;   // metres: half of the gaps that do not end a floor

/// Of each grid point, whether it is something.
using Marks = std::vector<uint8_t>;

class FloorMarks {
 public:
  explicit FloorMarks(const FreeSpace& grid) : grid_(grid), marks_(grid.clearance.size()) {}

  void add(const torch::Tensor& points) {
    const torch::Tensor level = points.index({points.select(1, 1).abs() < kLevel}).to(torch::kFloat64).contiguous();
    const auto p = level.accessor<double, 2>();
    for (int64_t i = 0; i < level.size(0); ++i) mark(Vector2d(p[i][0], p[i][2]));
  }

  void add(const Mesh& mesh) {
    if (mesh.faces.numel() == 0) return;
    const torch::Tensor vertices = mesh.vertices.to(torch::kFloat64).contiguous(),
                        faces = mesh.faces.to(torch::kInt64).contiguous();
    const auto v = vertices.accessor<double, 2>();
    const auto f = faces.accessor<int64_t, 2>();
    for (int64_t i = 0; i < f.size(0); ++i) {
      std::array<Vector2d, 3> corners;
      bool level = true;
      for (int64_t k = 0; k < 3; ++k) {
        const auto corner = v[f[i][k]];
        level = level && std::abs(corner[1]) < kLevel;
        corners[static_cast<size_t>(k)] = {corner[0], corner[2]};
      }
      if (level) add(corners);
    }
  }

  Marks take() { return std::move(marks_); }

 private:
  void mark(const Vector2d& at) {
    const Vector2d cell = (at - grid_.origin) / grid_.cell;
    if (!(cell.minCoeff() > -0.5 && cell.x() < grid_.nx - 0.5 && cell.y() < grid_.nz - 0.5)) return;
    set(static_cast<int>(std::lround(cell.x())), static_cast<int>(std::lround(cell.y())));
  }

  void set(int i, int k) {
    marks_[static_cast<size_t>(k) * static_cast<size_t>(grid_.nx) + static_cast<size_t>(i)] = 1;
  }

  /// Grid points in a triangle, and the one that is nearest to its middle: those of scans are smaller than cells.
  void add(const std::array<Vector2d, 3>& corners) {
    mark((corners[0] + corners[1] + corners[2]) / 3);
    Eigen::AlignedBox2d box;
    for (const Vector2d& corner : corners) box.extend(corner);
    const Vector2d low = (box.min() - grid_.origin) / grid_.cell, high = (box.max() - grid_.origin) / grid_.cell;
    const auto from = [](double cell) { return static_cast<int>(std::ceil(std::max(0.0, cell))); };
    const auto to = [](double cell, int points) { return static_cast<int>(std::floor(std::min(points - 1.0, cell))); };
    for (int k = from(low.y()); k <= to(high.y(), grid_.nz); ++k)
      for (int i = from(low.x()); i <= to(high.x(), grid_.nx); ++i) {
        bool left = true, right = true;
        for (size_t c = 0; c < 3; ++c) {
          const Vector2d side = corners[(c + 1) % 3] - corners[c], off = grid_.point(i, k) - corners[c];
          const double cross = side.x() * off.y() - side.y() * off.x();
          left = left && cross >= 0;
          right = right && cross <= 0;
        }
        if (left != right) set(i, k);
      }
  }

  const FreeSpace& grid_;
  Marks marks_;
};

/// Metres from each grid point to the nearest that is marked, up to `reach`.
std::vector<float> distances_to(const Marks& marks, const FreeSpace& grid, double reach) {
  const auto cells = static_cast<int>(reach / grid.cell);
  std::vector<float> out(marks.size(), static_cast<float>(reach));
  const auto at = [&](int i, int k) {
    return static_cast<size_t>(k) * static_cast<size_t>(grid.nx) + static_cast<size_t>(i);
  };
  for (int k = 0; k < grid.nz; ++k)
    for (int i = 0; i < grid.nx; ++i) {
      if (marks[at(i, k)] == 0) continue;
      out[at(i, k)] = 0;
      const auto inner = [&](int di, int dk) {
        return i + di < 0 || k + dk < 0 || i + di >= grid.nx || k + dk >= grid.nz || marks[at(i + di, k + dk)] != 0;
      };
      if (inner(-1, 0) && inner(1, 0) && inner(0, -1) && inner(0, 1)) continue;  // none is nearest to it alone
      for (int dk = std::max(-cells, -k); dk <= std::min(cells, grid.nz - 1 - k); ++dk)
        for (int di = std::max(-cells, -i); di <= std::min(cells, grid.nx - 1 - i); ++di) {
          float& far = out[at(i + di, k + dk)];
          far = std::min(far, static_cast<float>(grid.cell * std::hypot(di, dk)));
        }
    }
  return out;
}

}  // namespace

FreeSpace free_floor(const Scene& scene, const Scene& obstacles, const Vector2d& place) {
  const Eigen::AlignedBox2d there = on_ground(bounding_box(scene));
  const Vector2d far = Vector2d::Constant(kFar);
  FreeSpace space = free_space(obstacles, 3, there.intersection({place - far, place + far}));
  FloorMarks floor(space);
  for (const Mesh& mesh : scene.meshes) floor.add(mesh);
  if (scene.points.defined()) floor.add(scene.points);
  Marks beyond = floor.take();
  {  // what is farther than kHole from all floor
    const std::vector<float> off = distances_to(beyond, space, kHole + space.cell);
    std::transform(off.begin(), off.end(), beyond.begin(), [](float d) { return static_cast<uint8_t>(d > kHole); });
  }
  FreeSpace end = space;
  end.clearance = distances_to(beyond, space, kHole + FreeSpace::kFarthest);
  for (float& d : end.clearance) d -= static_cast<float>(kHole);
  if (!(end.at(place) > 0)) return space;
  std::transform(space.clearance.begin(), space.clearance.end(), end.clearance.begin(), space.clearance.begin(),
                 [](float obstacle, float edge) { return std::min(obstacle, edge); });
  return space;
}

}  // namespace inhabit
