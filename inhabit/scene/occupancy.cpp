#include "inhabit/scene/occupancy.h"

#include <ATen/Parallel.h>

#include <atomic>

#include "inhabit/error.h"

namespace inhabit {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr int64_t kFacesTogether = 512;  // that a thread looks at

using Corners = std::array<Vector3d, 3>;  // of a triangle, in cells: cell (i, j, k) spans [i, i + 1) and so on

/// Cells [low, high) along each axis.
struct Region {
  Vector3i low = Vector3i::Zero(), high = Vector3i::Zero();
  bool empty() const { return (high.array() <= low.array()).any(); }
};

Region cells_around(const Vector3d& lower, const Vector3d& upper, const Vector3i& cells) {
  Region region;
  for (int axis = 0; axis < 3; ++axis) {
    region.low[axis] = static_cast<int>(std::clamp(std::floor(lower[axis]), 0.0, static_cast<double>(cells[axis])));
    region.high[axis] =
        static_cast<int>(std::clamp(std::floor(upper[axis]) + 1, 0.0, static_cast<double>(cells[axis])));
  }
  return region;
}

/// True when the triangle meets the unit cube around `middle`: no axis separates them (Akenine-Moeller 2001).
bool meets_cell(const Corners& triangle, const Vector3d& middle) {
  constexpr double half = 0.5 + 1e-9;
  const Corners t{triangle[0] - middle, triangle[1] - middle, triangle[2] - middle};
  const auto separates = [&](const Vector3d& axis) {
    const double a = t[0].dot(axis), b = t[1].dot(axis), c = t[2].dot(axis);
    const double reach = half * axis.cwiseAbs().sum();
    return std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach;
  };
  for (int axis = 0; axis < 3; ++axis) {
    if (separates(Vector3d::Unit(axis))) return false;
  }
  const std::array<Vector3d, 3> edges{t[1] - t[0], t[2] - t[1], t[0] - t[2]};
  if (separates(edges[0].cross(edges[1]))) return false;
  for (const Vector3d& edge : edges) {
    for (int axis = 0; axis < 3; ++axis) {
      if (separates(Vector3d::Unit(axis).cross(edge))) return false;
    }
  }
  return true;
}

/// Cells that several threads fill: what one of them sets to 1 stays.
struct Grid {
  Vector3i cells;
  float* values;
  std::atomic_ref<float> at(const Vector3i& c) const {
    return std::atomic_ref<float>(values[(static_cast<int64_t>(c.x()) * cells.y() + c.y()) * cells.z() + c.z()]);
  }
  bool free(const Vector3i& c) const { return at(c).load(std::memory_order_relaxed) < 0; }
  void fill(const Vector3i& c) const { at(c).store(1, std::memory_order_relaxed); }
};

/// Along the axis that a triangle faces most, its plane crosses each column of cells between two heights: only cells
/// there are asked whether they meet the triangle.
void mark_surface(const Corners& t, const Grid& grid) {
  const Region region =
      cells_around(t[0].cwiseMin(t[1]).cwiseMin(t[2]), t[0].cwiseMax(t[1]).cwiseMax(t[2]), grid.cells);
  if (region.empty()) return;
  const bool in_one_cell = (region.high - region.low).sum() == 3;
  const Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
  int axis = 0;
  const double most = normal.cwiseAbs().maxCoeff(&axis);
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const bool flat = most > 0;  // else it has no area and no plane
  const Vector3d slope = flat ? Vector3d(normal / normal[axis]) : Vector3d::Zero();
  const double reach = 0.5 * (std::abs(slope[u]) + std::abs(slope[v])) + 1e-6;
  Vector3i c;
  for (c[u] = region.low[u]; c[u] < region.high[u]; ++c[u]) {
    for (c[v] = region.low[v]; c[v] < region.high[v]; ++c[v]) {
      int low = region.low[axis], high = region.high[axis];
      if (flat) {
        const double middle = slope.dot(t[0]) - slope[u] * (c[u] + 0.5) - slope[v] * (c[v] + 0.5);
        const auto within = [&](double x) {
          return static_cast<int>(std::clamp<double>(x, region.low[axis], region.high[axis]));
        };
        low = within(std::floor(middle - reach));
        high = within(std::floor(middle + reach) + 1);
      }
      for (c[axis] = low; c[axis] < high; ++c[axis])
        if (grid.free(c) && (in_one_cell || meets_cell(t, c.cast<double>() + Vector3d::Constant(0.5)))) grid.fill(c);
    }
  }
}

struct SolidFace {
  Corners corners;
  int outward;
};

/// Marks the cells of `region` whose middles lie inside one body. Along every row of cells, in all three directions,
/// faces are crossed; what a look forward and a look back count adds up to the winding number, times six.
void mark_inside(const std::vector<SolidFace>& faces, const Region& region, const Grid& grid) {
  const Vector3i size = region.high - region.low;
  std::vector<int> windings(static_cast<size_t>(size.x()) * static_cast<size_t>(size.y()) *
                            static_cast<size_t>(size.z()));
  const auto index = [&](const Vector3i& c) {
    return (static_cast<size_t>(c.x()) * static_cast<size_t>(size.y()) + static_cast<size_t>(c.y())) *
               static_cast<size_t>(size.z()) +
           static_cast<size_t>(c.z());
  };
  std::vector<int> steps;
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const int length = size[axis] + 1;
    steps.assign(static_cast<size_t>(size[u]) * static_cast<size_t>(size[v]) * static_cast<size_t>(length), 0);
    const auto step_row = [&](int i, int j) {
      return steps.data() + (static_cast<size_t>(i) * static_cast<size_t>(size[v]) + static_cast<size_t>(j)) *
                                static_cast<size_t>(length);
    };
    for (const SolidFace& face : faces) {
      const Corners& t = face.corners;
      // Twice the area of the triangle seen along the axis; its sign says which side is seen.
      const auto cross = [&](const Vector3d& a, const Vector3d& b, double pu, double pv) {
        return (b[u] - a[u]) * (pv - a[v]) - (b[v] - a[v]) * (pu - a[u]);
      };
      const double area = cross(t[0], t[1], t[2][u], t[2][v]);
      if (area == 0) continue;
      const int sign = (area > 0 ? 1 : -1) * face.outward;  // +1 where the axis leads out of the body
      const auto middles = [&](int a) {                     // rows whose middles may lie in the triangle
        const double low = std::min({t[0][a], t[1][a], t[2][a]}) - region.low[a],
                     high = std::max({t[0][a], t[1][a], t[2][a]}) - region.low[a];
        return std::pair{static_cast<int>(std::clamp(std::ceil(low - 0.5), 0.0, static_cast<double>(size[a]))),
                         static_cast<int>(std::clamp(std::floor(high - 0.5) + 1, 0.0, static_cast<double>(size[a])))};
      };
      const auto [u0, u1] = middles(u);
      const auto [v0, v1] = middles(v);
      for (int i = u0; i < u1; ++i) {
        for (int j = v0; j < v1; ++j) {
          const double pu = region.low[u] + i + 0.5, pv = region.low[v] + j + 0.5;
          // A middle exactly on an edge belongs to one of the edge's two triangles: that on its left as the edge runs
          // up.
          const auto covers = [&](const Vector3d& a, const Vector3d& b, double& weight) {
            weight = cross(a, b, pu, pv);
            if (weight != 0) return (weight > 0) == (area > 0);
            const bool up = b[v] > a[v] || (b[v] == a[v] && b[u] < a[u]);
            return up == (area > 0);
          };
          double wa, wb, wc;
          if (!covers(t[1], t[2], wa) || !covers(t[2], t[0], wb) || !covers(t[0], t[1], wc)) continue;
          const double depth =
              (wa * t[0][axis] + wb * t[1][axis] + wc * t[2][axis]) / (wa + wb + wc) - region.low[axis];
          // The first middle beyond the face, or none of this row.
          const int first = static_cast<int>(std::clamp(std::ceil(depth - 0.5), 0.0, static_cast<double>(size[axis])));
          step_row(i, j)[first] += sign;
        }
      }
    }
    for (int i = 0; i < size[u]; ++i) {
      for (int j = 0; j < size[v]; ++j) {
        const int* row = step_row(i, j);
        int total = 0;
        for (int k = 0; k < length; ++k) total += row[k];
        int behind = 0;
        for (int k = 0; k < size[axis]; ++k) {
          behind += row[k];
          Vector3i c;
          c[u] = i, c[v] = j, c[axis] = k;
          windings[index(c)] += (total - behind) - behind;
        }
      }
    }
  }
  Vector3i c;
  for (c.x() = 0; c.x() < size.x(); ++c.x()) {
    for (c.y() = 0; c.y() < size.y(); ++c.y()) {
      for (c.z() = 0; c.z() < size.z(); ++c.z()) {
        if (Solid::holds(windings[index(c)], 6)) grid.fill(c + region.low);
      }
    }
  }
}

}  // namespace

torch::Tensor occupancy_grid(const Solid& solid, const Vector3d& center, double heading, const OccupancyShape& shape) {
  const Vector3i cells(shape.cells[0], shape.cells[1], shape.cells[2]);
  if ((cells.array() < 1).any() || cells.cast<double>().prod() > 268435456.0 || !(shape.cell > 0)) {
    throw Error("an occupancy grid must have 1 to 2^28 cells of a positive size");
  }
  if (!center.allFinite() || !std::isfinite(heading))
    throw Error("an occupancy grid is placed where nothing is finite");
  torch::Tensor out = torch::full({cells.x(), cells.y(), cells.z()}, -1.F);
  const Grid grid{cells, out.data_ptr<float>()};
  const double c = std::cos(heading), s = std::sin(heading);
  Eigen::Matrix3d to_person;  // rotates by -heading about +Y
  to_person << c, 0, -s, 0, 1, 0, s, 0, c;
  const auto to_cells = [&](const Eigen::Vector3f& p) -> Vector3d {
    return to_person * (p.cast<double>() - center) / shape.cell + cells.cast<double>() / 2;
  };

  std::vector<Vector3d> vertices;
  vertices.reserve(solid.vertices.size());
  for (const Eigen::Vector3f& vertex : solid.vertices) vertices.push_back(to_cells(vertex));
  std::vector<Vector3d> lower(static_cast<size_t>(solid.bodies), Vector3d::Constant(HUGE_VAL));
  std::vector<Vector3d> upper(static_cast<size_t>(solid.bodies), Vector3d::Constant(-HUGE_VAL));
  for (size_t face = 0; face < solid.faces.size(); ++face) {
    const auto& f = solid.faces[face];
    const Corners t{vertices[f[0]], vertices[f[1]], vertices[f[2]]};
    const auto body = static_cast<size_t>(solid.body[face]);
    for (const Vector3d& corner : t) {
      lower[body] = lower[body].cwiseMin(corner);
      upper[body] = upper[body].cwiseMax(corner);
    }
  }
  at::parallel_for(0, static_cast<int64_t>(solid.faces.size()), kFacesTogether, [&](int64_t begin, int64_t end) {
    for (auto face = static_cast<size_t>(begin); face < static_cast<size_t>(end); ++face) {
      const auto& f = solid.faces[face];
      mark_surface({vertices[f[0]], vertices[f[1]], vertices[f[2]]}, grid);
    }
  });
  std::vector<Region> regions(lower.size());
  for (size_t body = 0; body < regions.size(); ++body) regions[body] = cells_around(lower[body], upper[body], cells);
  std::vector<std::vector<SolidFace>> faces(regions.size());
  for (size_t face = 0; face < solid.faces.size(); ++face) {
    const auto body = static_cast<size_t>(solid.body[face]);
    if (regions[body].empty()) continue;
    const auto& f = solid.faces[face];
    faces[body].push_back({{vertices[f[0]], vertices[f[1]], vertices[f[2]]}, solid.outward[face]});
  }
  at::parallel_for(0, static_cast<int64_t>(regions.size()), 1, [&](int64_t begin, int64_t end) {
    for (auto body = static_cast<size_t>(begin); body < static_cast<size_t>(end); ++body)
      if (!regions[body].empty()) mark_inside(faces[body], regions[body], grid);
  });

  for (const Eigen::Vector3f& point : solid.points) {
    const Vector3d at = to_cells(point);
    const Region region = cells_around(at, at, cells);
    if (!region.empty()) grid.fill(region.low);
  }
  return out;
}

}  // namespace inhabit
