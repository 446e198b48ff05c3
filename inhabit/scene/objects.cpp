#include "inhabit/scene/objects.h"

#include <algorithm>

namespace inhabit {

std::string object_of_mesh(const std::string& mesh_name) {
  const size_t dot = mesh_name.rfind('.');
  if (dot == std::string::npos || dot + 1 == mesh_name.size()) return mesh_name;
  const bool number = std::all_of(mesh_name.begin() + static_cast<long>(dot) + 1, mesh_name.end(),
                                  [](char c) { return c >= '0' && c <= '9'; });
  return number ? mesh_name.substr(0, dot) : mesh_name;
}

bool is_floor(const std::string& mesh_name) {
  const std::string object = object_of_mesh(mesh_name);
  return object == "floor" || object == "rug";
}

Scene obstacles_of(const Scene& scene, const std::string& without) {
  Scene out;
  out.name = scene.name;
  for (const Mesh& mesh : scene.meshes)
    if (!is_floor(mesh.name) && (without.empty() || object_of_mesh(mesh.name) != without)) out.meshes.push_back(mesh);
  return out;
}

}  // namespace inhabit
