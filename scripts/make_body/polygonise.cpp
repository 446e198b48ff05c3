#include "polygonise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

namespace inhabit {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

Vector3d gradient(const SurfaceDistance& field, const Vector3d& p) {
  constexpr double h = 1e-4;
  Vector3d g;
  for (int i = 0; i < 3; ++i) {
    const Vector3d step = h * Vector3d::Unit(i);
    g[i] = (field(p + step) - field(p - step)) / (2 * h);
  }
  return g;
}

/// Newton steps onto the surface.
Vector3d onto_surface(const SurfaceDistance& field, Vector3d p) {
  const bool on_plane = p.x() == 0;
  for (int step = 0; step < 3; ++step) {
    const Vector3d g = gradient(field, p);
    const double d = field(p);
    if (g.squaredNorm() < 1e-4 || std::abs(d) < 1e-6) break;
    p -= std::clamp(d / g.squaredNorm(), -0.02, 0.02) * g;
    if (on_plane) p.x() = 0;
  }
  return p;
}

/// The grid and the surface being collected from it.
struct Marcher {
  const SurfaceDistance& field;
  Vector3d low;
  double cell;
  Vector3i corners;  ///< grid points along each axis
  std::unordered_map<int64_t, double> values;
  std::unordered_map<int64_t, int> edge_vertices;
  TriangleSurface surface;

  int64_t index(const Vector3i& c) const {
    return (static_cast<int64_t>(c.x()) * corners.y() + c.y()) * corners.z() + c.z();
  }
  Vector3d place(const Vector3i& c) const { return low + cell * c.cast<double>(); }
  double value(const Vector3i& c) {
    const auto [it, is_new] = values.try_emplace(index(c), 0.0);
    if (is_new) it->second = field(place(c));
    return it->second;
  }
  int vertex_between(const Vector3i& a, const Vector3i& b, double va, double vb) {
    const int64_t ia = index(a), ib = index(b), total = static_cast<int64_t>(corners.prod());
    const auto [it, is_new] = edge_vertices.try_emplace(std::min(ia, ib) * total + std::max(ia, ib), 0);
    if (is_new) {
      it->second = static_cast<int>(surface.vertices.size());
      // Kept off the grid points, where several edges would share one position.
      const double t = std::clamp(va / (va - vb), 0.02, 0.98);
      surface.vertices.push_back(place(a) + t * (place(b) - place(a)));
    }
    return it->second;
  }
  void tetrahedron(const std::array<Vector3i, 4>& c, const std::array<double, 4>& v) {
    std::array<int, 4> in{}, out{};
    int n_in = 0, n_out = 0;
    for (int i = 0; i < 4; ++i) (v[i] < 0 ? in[n_in++] : out[n_out++]) = i;
    if (n_in == 0 || n_out == 0) return;
    const auto cut = [&](int i, int o) { return vertex_between(c[i], c[o], v[i], v[o]); };
    if (n_in == 1) triangle(cut(in[0], out[0]), cut(in[0], out[1]), cut(in[0], out[2]), c[in[0]], c[out[0]]);
    if (n_in == 3) triangle(cut(in[0], out[0]), cut(in[1], out[0]), cut(in[2], out[0]), c[in[0]], c[out[0]]);
    if (n_in == 2) {
      const int a = cut(in[0], out[0]), b = cut(in[0], out[1]), d = cut(in[1], out[1]), e = cut(in[1], out[0]);
      triangle(a, b, d, c[in[0]], c[out[0]]);
      triangle(a, d, e, c[in[0]], c[out[0]]);
    }
  }
  /// Turned so that its front looks from an inner towards an outer grid point.
  void triangle(int a, int b, int d, const Vector3i& inner, const Vector3i& outer) {
    const auto& x = surface.vertices;
    const Vector3d normal = (x[b] - x[a]).cross(x[d] - x[a]);
    // The inner grid point is behind every triangle of its tetrahedron, the outer one before it.
    const bool turned = normal.dot(place(outer) - x[a]) - normal.dot(place(inner) - x[a]) < 0;
    surface.faces.emplace_back(a, turned ? d : b, turned ? b : d);
  }
};

std::vector<std::vector<int>> neighbours_of(const TriangleSurface& s) {
  std::vector<std::vector<int>> near(s.vertices.size());
  for (const Vector3i& f : s.faces)
    for (int i = 0; i < 3; ++i) {
      near[f[i]].push_back(f[(i + 1) % 3]);
      near[f[i]].push_back(f[(i + 2) % 3]);
    }
  for (auto& list : near) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return near;
}

/// From a vertex to the mean of its neighbours; in the plane x = 0 only neighbours there count.
Vector3d to_neighbours(const TriangleSurface& surface, const std::vector<int>& near, size_t v) {
  const bool on_plane = surface.vertices[v].x() == 0;
  Vector3d mean = Vector3d::Zero();
  int count = 0;
  for (int n : near) {
    if (on_plane && surface.vertices[n].x() != 0) continue;
    mean += surface.vertices[n];
    ++count;
  }
  return count == 0 ? mean : Vector3d(mean / count - surface.vertices[v]);
}

}  // namespace

TriangleSurface polygonise(const SurfaceDistance& field, const Vector3d& low, const Vector3d& high, double cell) {
  constexpr int kBlock = 6;  // cells along a block's edge
  const Vector3i cells = ((high - low) / cell).array().ceil().cast<int>();
  Marcher marcher{field, low, cell, cells + Vector3i::Ones(), {}, {}, {}};
  // Corner c of a cell is at (c & 1, c >> 1 & 1, c >> 2 & 1). Six tetrahedra around the diagonal 0-7; neighbouring
  // cells split their common side the same way.
  constexpr int kTetrahedra[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                                     {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
  const Vector3i blocks = (cells + Vector3i::Constant(kBlock - 1)) / kBlock;
  const double block_radius = 0.5 * kBlock * cell * std::sqrt(3.0);
  for (int bx = 0; bx < blocks.x(); ++bx)
    for (int by = 0; by < blocks.y(); ++by)
      for (int bz = 0; bz < blocks.z(); ++bz) {
        const Vector3i first = kBlock * Vector3i(bx, by, bz);
        const Vector3d middle = marcher.place(first) + Vector3d::Constant(0.5 * kBlock * cell);
        // Half as much again as a true distance would need: the field is only near to one.
        if (std::abs(field(middle)) > 1.5 * block_radius) continue;
        const Vector3i last = (first + Vector3i::Constant(kBlock)).cwiseMin(cells);
        for (int x = first.x(); x < last.x(); ++x)
          for (int y = first.y(); y < last.y(); ++y)
            for (int z = first.z(); z < last.z(); ++z) {
              std::array<Vector3i, 8> corner;
              std::array<double, 8> value;
              int inside = 0;
              for (int c = 0; c < 8; ++c) {
                corner[c] = Vector3i(x + (c & 1), y + ((c >> 1) & 1), z + (c >> 2));
                value[c] = marcher.value(corner[c]);
                inside += value[c] < 0;
              }
              if (inside == 0 || inside == 8) continue;
              for (const auto& t : kTetrahedra)
                marcher.tetrahedron({corner[t[0]], corner[t[1]], corner[t[2]], corner[t[3]]},
                                    {value[t[0]], value[t[1]], value[t[2]], value[t[3]]});
            }
      }
  return std::move(marcher.surface);
}

void smooth(TriangleSurface& surface, int rounds) {
  const auto near = neighbours_of(surface);
  for (int round = 0; round < rounds; ++round) {
    std::vector<Vector3d> moved = surface.vertices;
    for (size_t v = 0; v < moved.size(); ++v) moved[v] += 0.5 * to_neighbours(surface, near[v], v);
    surface.vertices = std::move(moved);
  }
}

void relax(const SurfaceDistance& field, TriangleSurface& surface, int rounds) {
  const auto near = neighbours_of(surface);
  for (int round = 0; round < rounds; ++round) {
    std::vector<Vector3d> moved = surface.vertices;
    for (size_t v = 0; v < moved.size(); ++v) {
      const Vector3d normal = gradient(field, moved[v]).normalized();
      Vector3d step = 0.5 * to_neighbours(surface, near[v], v);
      step -= step.dot(normal) * normal;
      if (moved[v].x() == 0) step.x() = 0;
      moved[v] = onto_surface(field, moved[v] + step);
    }
    surface.vertices = std::move(moved);
  }
}

TriangleSurface mirrored(const TriangleSurface& half) {
  TriangleSurface whole = half;
  std::vector<int> other(half.vertices.size());
  for (size_t v = 0; v < half.vertices.size(); ++v) {
    other[v] = static_cast<int>(v);
    if (half.vertices[v].x() == 0) continue;
    other[v] = static_cast<int>(whole.vertices.size());
    whole.vertices.push_back(half.vertices[v].cwiseProduct(Vector3d(-1, 1, 1)));
  }
  for (const Vector3i& f : half.faces) whole.faces.emplace_back(other[f[0]], other[f[2]], other[f[1]]);
  return whole;
}

}  // namespace inhabit
