#include <algorithm>

#include "inhabit/error.h"
#include "inhabit/view/page_parts.h"

namespace inhabit {

using nlohmann::json;

namespace {

/// Vertices in one cell of a grid become one; triangles that collapse go. Cells grow until `target` triangles remain.
Mesh thinned(const Mesh& mesh, int64_t target) {
  const torch::Tensor vertices = plain(mesh.vertices), faces = plain(mesh.faces, torch::kInt64);
  const torch::Tensor low = std::get<0>(vertices.min(0)), extent = std::get<0>(vertices.max(0)) - low;
  double cell = std::max(1e-4, extent.max().item<double>() / 1024);
  for (Mesh out = mesh;; cell *= 1.3) {
    if (out.faces.size(0) <= target) return out;
    const torch::Tensor q = ((vertices - low) / cell).floor().to(torch::kInt64);
    const torch::Tensor key = (q.select(1, 0) * 2048 + q.select(1, 1)) * 2048 + q.select(1, 2);
    const auto [unique, inverse, counts] = at::_unique2(key, true, true, true);
    out.vertices =
        torch::zeros({unique.size(0), 3}).index_add_(0, inverse, vertices) / counts.to(torch::kFloat32).unsqueeze(1);
    const torch::Tensor f = inverse.index({faces.reshape({-1})}).reshape({-1, 3});
    const torch::Tensor a = f.select(1, 0), b = f.select(1, 1), c = f.select(1, 2);
    out.faces = f.index({(a != b) & (b != c) & (a != c)});
  }
}

}  // namespace

json describe_scene(PageBlob& blob, const Scene& scene, const std::string& path, int64_t most_triangles,
                    int64_t most_points) {
  int64_t triangles = 0;
  for (const Mesh& mesh : scene.meshes) triangles += mesh.faces.defined() ? mesh.faces.size(0) : 0;
  json out = {{"meshes", json::array()}};
  for (const Mesh& full : scene.meshes) {
    if (!full.faces.defined() || full.faces.numel() == 0) continue;
    require_finite(full.vertices, path, "mesh " + full.name + " of the scene");
    if (full.faces.min().item<int64_t>() < 0 || full.faces.max().item<int64_t>() >= full.vertices.size(0))
      throw Error(path, "mesh " + full.name + " of the scene names a vertex it does not have");
    const Mesh mesh =
        triangles > most_triangles ? thinned(full, full.faces.size(0) * most_triangles / triangles) : full;
    out["meshes"].push_back({{"name", mesh.name},
                             {"color", mesh.color},
                             {"vertices", blob.add_positions(mesh.vertices)},
                             {"faces", blob.add_indices(mesh.faces, mesh.vertices.size(0))}});
  }
  if (scene.points.defined() && scene.points.numel() > 0) {
    require_finite(scene.points, path, "the scene's point cloud");
    const int64_t n = scene.points.size(0), stride = (n + most_points - 1) / most_points;
    out["points"] = blob.add_positions(scene.points.slice(0, 0, n, stride));
  }
  return out;
}

}  // namespace inhabit
