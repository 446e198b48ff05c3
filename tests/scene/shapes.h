#pragma once
#include "inhabit/scene/scene.h"

namespace inhabit {

/// A box with outward faces around `center`, `size` along each axis; of its six sides those not in `without` (0 -x, 1
/// +x, 2 -y, 3 +y, 4 -z, 5 +z) are there.
inline Mesh box_mesh(const std::array<double, 3>& center, const std::array<double, 3>& size,
                     const std::vector<int>& without = {}) {
  std::vector<float> vertices;
  for (int corner = 0; corner < 8; ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      const double side = (corner >> axis) % 2 == 0 ? -0.5 : 0.5;
      const auto a = static_cast<size_t>(axis);
      vertices.push_back(static_cast<float>(center[a] + side * size[a]));
    }
  }
  const std::vector<std::array<int64_t, 4>> sides{{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                                  {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  std::vector<int64_t> faces;
  for (int side = 0; side < 6; ++side) {
    if (std::find(without.begin(), without.end(), side) != without.end()) continue;
    const auto& s = sides[static_cast<size_t>(side)];
    faces.insert(faces.end(), {s[0], s[1], s[2], s[0], s[2], s[3]});
  }
  Mesh mesh;
  mesh.name = "box";
  mesh.vertices = torch::tensor(vertices).view({-1, 3});
  mesh.faces = torch::tensor(faces, torch::kInt64).view({-1, 3});
  return mesh;
}

/// A closed sphere of rings * 2 * rings * 2 triangles or so, faces outward.
inline Mesh sphere_mesh(const std::array<double, 3>& center, double radius, int rings) {
  const int around = 2 * rings;
  std::vector<float> vertices;
  const auto add = [&](double x, double y, double z) {
    vertices.insert(vertices.end(),
                    {static_cast<float>(center[0] + radius * x), static_cast<float>(center[1] + radius * y),
                     static_cast<float>(center[2] + radius * z)});
  };
  add(0, 1, 0);
  for (int i = 1; i < rings; ++i) {
    const double polar = M_PI * i / rings;
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * M_PI * k / around;
      add(std::sin(polar) * std::sin(angle), std::cos(polar), std::sin(polar) * std::cos(angle));
    }
  }
  add(0, -1, 0);
  const auto at = [&](int ring, int k) -> int64_t { return 1 + (ring - 1) * around + k % around; };
  const int64_t last = 1 + static_cast<int64_t>(rings - 1) * around;
  std::vector<int64_t> faces;
  for (int k = 0; k < around; ++k) {
    faces.insert(faces.end(), {0, at(1, k), at(1, k + 1)});
    for (int i = 1; i + 1 < rings; ++i) {
      faces.insert(faces.end(), {at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k), at(i + 1, k + 1), at(i, k + 1)});
    }
    faces.insert(faces.end(), {last, at(rings - 1, k + 1), at(rings - 1, k)});
  }
  Mesh mesh;
  mesh.name = "sphere";
  mesh.vertices = torch::tensor(vertices).view({-1, 3});
  mesh.faces = torch::tensor(faces, torch::kInt64).view({-1, 3});
  return mesh;
}

inline Scene scene_of(std::vector<Mesh> meshes) {
  Scene scene;
  scene.meshes = std::move(meshes);
  return scene;
}

/// Every face, or the given ones, looking the other way.
inline Mesh flipped(Mesh mesh, const std::vector<int64_t>& faces = {}) {
  mesh.faces = mesh.faces.clone();
  if (faces.empty()) mesh.faces = mesh.faces.flip({1}).contiguous();
  for (const int64_t face : faces) mesh.faces[face] = mesh.faces[face].flip({0}).clone();
  return mesh;
}

}  // namespace inhabit
