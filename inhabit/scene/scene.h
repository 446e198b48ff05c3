#pragma once
#include <torch/types.h>

#include <array>
#include <string>
#include <vector>

namespace inhabit {

/// A triangle mesh in world coordinates, metres, +Y up.
struct Mesh {
  std::string name;                                 ///< tells floors, seats and objects apart (objects.h)
  torch::Tensor vertices;                           ///< (V, 3) float
  torch::Tensor faces;                              ///< (F, 3) int64
  std::array<float, 3> color{0.75F, 0.73F, 0.70F};  ///< linear RGB
};

/// What a person moves in: meshes, points of a scan, or both.
struct Scene {
  std::string name;          ///< of the file, for errors and pages
  std::vector<Mesh> meshes;  ///< an object each
  torch::Tensor points;      ///< (N, 3) metres, undefined when there is no point cloud

  /// Neither meshes nor points.
  bool empty() const { return meshes.empty() && !points.defined(); }
};

/// A flat floor, y = 0, `size` metres on a side around (x, z) = center: what is assumed where no scene is given.
Scene floor_scene(double size = 12.0, double center_x = 0.0, double center_z = 0.0);

/// All meshes of a scene as one.
Mesh merged_mesh(const Scene& scene);

}  // namespace inhabit
