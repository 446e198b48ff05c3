#include "inhabit/io/mesh.h"
#include "inhabit/io/atomic_file.h"

#include <map>

#include "inhabit/error.h"
#include "inhabit/io/assimp_scene.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/gltf_scene.h"
#include "inhabit/io/obj.h"
#include "inhabit/io/ply.h"
#include "inhabit/io/stl.h"

namespace inhabit {
namespace {

/// @param folder where files that it refers to lie; empty: they are not read.
std::vector<Mesh> parse(std::string_view bytes, const std::string& extension, const std::string& subject,
                        const std::string& folder, MeshAxes* axes) {
  if (bytes.empty()) throw Error(subject, "is empty");
  if (extension == "ply") return {parse_ply(bytes, subject, axes)};
  if (extension == "stl") return {parse_stl(bytes, subject)};
  if (extension == "off") return {parse_off(bytes, subject)};
  if (extension == "glb" || extension == "gltf") return parse_gltf(bytes, subject, folder);
  if (extension == "fbx" || extension == "dae") return parse_node_meshes(bytes, extension, subject, axes);
  if (extension == "obj") {
    return parse_obj(bytes, subject, [&](const std::string& name) {
      std::error_code failed;
      const std::string file = (std::filesystem::path(folder) / name).string();
      return !folder.empty() && std::filesystem::is_regular_file(file, failed) ? read_whole_file(file) : std::string();
    });
  }
  throw Error(subject, "'" + extension + "' is no mesh format; known are obj, ply, glb, gltf, fbx, dae, off, stl");
}

/// Gives meshes without a name that of the file, and a number to all but the first of those with one name.
std::vector<Mesh> numbered(std::vector<Mesh> meshes, const std::string& subject) {
  std::map<std::string, int> times;
  for (Mesh& mesh : meshes) {
    if (mesh.name.empty()) mesh.name = std::filesystem::path(subject).stem().string();
    const int before = times[mesh.name]++;
    if (before > 0) mesh.name += "." + std::to_string(before);
  }
  return meshes;
}

}  // namespace

std::vector<Mesh> read_meshes(const std::string& path, MeshAxes* axes) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return numbered(parse(read_whole_file(path), extension_of(path), path, folder.empty() ? "." : folder, axes), path);
}

std::vector<Mesh> parse_meshes(std::string_view bytes, const std::string& extension, const std::string& subject,
                               MeshAxes* axes) {
  return numbered(parse(bytes, extension, subject, "", axes), subject);
}

int64_t drop_degenerate_faces(Mesh& mesh) {
  if (mesh.faces.size(0) == 0) return 0;
  const torch::Tensor vertices = mesh.vertices.to(torch::kFloat64);
  const torch::Tensor corners = vertices.index_select(0, mesh.faces.reshape({-1})).view({-1, 3, 3});
  const torch::Tensor normals =
      torch::cross(corners.select(1, 1) - corners.select(1, 0), corners.select(1, 2) - corners.select(1, 0), 1);
  const double size = (std::get<0>(vertices.max(0)) - std::get<0>(vertices.min(0))).norm().item<double>();
  const torch::Tensor keep = normals.norm(2, 1) > 1e-12 * size * size;
  const int64_t dropped = mesh.faces.size(0) - keep.sum().item<int64_t>();
  if (dropped > 0) mesh.faces = mesh.faces.index({keep});
  return dropped;
}

}  // namespace inhabit
