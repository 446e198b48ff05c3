#include "inhabit/scene/bounding_box.h"

namespace inhabit {

Eigen::AlignedBox3d bounding_box(const Scene& scene) {
  Eigen::AlignedBox3d box;
  const auto extend = [&](const torch::Tensor& points) {
    if (!points.defined() || points.numel() == 0) return;
    for (const torch::Tensor& corner : {std::get<0>(points.min(0)), std::get<0>(points.max(0))})
      box.extend(Eigen::Vector3d(corner[0].item<double>(), corner[1].item<double>(), corner[2].item<double>()));
  };
  for (const Mesh& mesh : scene.meshes) extend(mesh.vertices);
  extend(scene.points);
  return box;
}

}  // namespace inhabit
