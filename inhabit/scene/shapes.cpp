#include "inhabit/scene/shapes.h"

#include <cmath>

namespace inhabit {

int64_t MeshBuilder::vertex(const Eigen::Vector3d& p) {
  for (int c = 0; c < 3; ++c) vertices_.push_back(static_cast<float>(p[c]));
  return static_cast<int64_t>(vertices_.size() / 3) - 1;
}

void MeshBuilder::quad(int64_t a, int64_t b, int64_t c, int64_t d) {
  for (const int64_t i : {a, b, c, a, c, d}) faces_.push_back(i);
}

void MeshBuilder::box(const Eigen::Vector3d& center, const Eigen::Vector3d& half, double radius, int steps) {
  // A grid over each side of the cube, its outer rings pulled in onto the rounded edges. Rounded boxes share vertices
  // between sides so that they shade smoothly; sharp ones do not, so that they shade flat.
  const double r = std::min(radius, 0.99 * half.minCoeff());
  const bool rounded = r > 0;
  const int ring = rounded ? steps : 0, n = rounded ? 2 * (ring + 1) : 2;
  auto coordinate = [&](int i, double h) {  // of grid line i in [0, n)
    if (!rounded) return i == 0 ? -h : h;
    const double inner = h - r;
    return i <= ring ? -h + r * i / ring : inner + r * (i - ring - 1) / ring;
  };
  auto on_surface = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    if (!rounded) return p;
    const Eigen::Vector3d inner_half = half.array() - r;
    const Eigen::Vector3d inner = p.cwiseMax(-inner_half).cwiseMin(inner_half);
    return inner + r * (p - inner).normalized();
  };
  const auto edge = static_cast<size_t>(n);
  std::vector<int64_t> known(rounded ? edge * edge * edge : 0, -1);
  auto at = [&](int i, int j, int k) {
    const Eigen::Vector3d p(coordinate(i, half.x()), coordinate(j, half.y()), coordinate(k, half.z()));
    if (!rounded) return vertex(center + p);
    int64_t& id = known[(static_cast<size_t>(i) * edge + static_cast<size_t>(j)) * edge + static_cast<size_t>(k)];
    if (id < 0) id = vertex(center + on_surface(p));
    return id;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {0, n - 1})
      for (int u = 0; u + 1 < n; ++u)
        for (int v = 0; v + 1 < n; ++v) {
          auto corner = [&](int du, int dv) {
            std::array<int, 3> i{};
            i[axis] = side;
            i[(axis + 1) % 3] = u + du;
            i[(axis + 2) % 3] = v + dv;
            return at(i[0], i[1], i[2]);
          };
          const int64_t a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
          side == 0 ? quad(a, d, c, b) : quad(a, b, c, d);
        }
}

void MeshBuilder::column(const Eigen::Vector3d& center, double y0, double y1, double r0, double r1, int sides) {
  auto ring = [&](double y, double r) {
    const int64_t first = static_cast<int64_t>(vertices_.size() / 3);
    for (int i = 0; i < sides; ++i) {
      const double a = 2 * M_PI * i / sides;
      vertex({center.x() + r * std::cos(a), y, center.z() + r * std::sin(a)});
    }
    return first;
  };
  const int64_t low = ring(y0, r0), high = ring(y1, r1), cap0 = ring(y0, r0), cap1 = ring(y1, r1);
  for (int i = 0; i < sides; ++i) {
    const int j = (i + 1) % sides;
    quad(low + i, high + i, high + j, low + j);
    if (i == 0 || j == 0) continue;
    for (const int64_t v : {cap0, cap0 + i, cap0 + j, cap1, cap1 + j, cap1 + i}) faces_.push_back(v);
  }
}

Mesh MeshBuilder::mesh(const std::string& name, const std::array<float, 3>& color) const {
  Mesh mesh;
  mesh.name = name;
  mesh.color = color;
  mesh.vertices = torch::tensor(vertices_).view({-1, 3});
  mesh.faces = torch::tensor(faces_, torch::kInt64).view({-1, 3});
  return mesh;
}

}  // namespace inhabit
