#include "inhabit/scene/objects.h"

#include <algorithm>

namespace inhabit {
namespace {

bool is_number(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

std::string object_of_mesh(const std::string& mesh_name) {
  const size_t dot = mesh_name.rfind('.');
  if (dot == std::string::npos || !is_number(mesh_name.substr(dot + 1))) return mesh_name;
  // "chair.001" is how modellers call a copy, which is another chair.
  const bool copy = mesh_name.size() - dot - 1 >= 3;
  return copy ? mesh_name : mesh_name.substr(0, dot);
}

bool is_floor(const std::string& mesh_name) {
  const size_t dot = mesh_name.rfind('.');
  const bool numbered = dot != std::string::npos && is_number(mesh_name.substr(dot + 1));
  const std::string object = numbered ? mesh_name.substr(0, dot) : mesh_name;
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
