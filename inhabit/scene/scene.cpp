#include "inhabit/scene/scene.h"

namespace inhabit {

Scene floor_scene(double size, double center_x, double center_z) {
  const float h = static_cast<float>(size / 2), x = static_cast<float>(center_x), z = static_cast<float>(center_z);
  Mesh floor;
  floor.name = "floor";
  floor.vertices =
      torch::tensor({x - h, 0.F, z - h, x - h, 0.F, z + h, x + h, 0.F, z + h, x + h, 0.F, z - h}).view({4, 3});
  floor.faces = torch::tensor({0, 1, 2, 0, 2, 3}, torch::kInt64).view({2, 3});
  Scene scene;
  scene.name = "floor";
  scene.meshes.push_back(std::move(floor));
  return scene;
}

Mesh merged_mesh(const Scene& scene) {
  Mesh out;
  out.name = scene.name;
  std::vector<torch::Tensor> vertices, faces;
  int64_t first = 0;
  for (const Mesh& mesh : scene.meshes) {
    vertices.push_back(mesh.vertices);
    faces.push_back(mesh.faces + first);
    first += mesh.vertices.size(0);
  }
  out.vertices = vertices.empty() ? torch::zeros({0, 3}) : torch::cat(vertices);
  out.faces = faces.empty() ? torch::zeros({0, 3}, torch::kInt64) : torch::cat(faces);
  return out;
}

}  // namespace inhabit
