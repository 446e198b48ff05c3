#include "inhabit/scene/basis_points.h"

namespace inhabit {

torch::Tensor basis_point_offsets(const SceneQuery& scene, const torch::Tensor& anchors) {
  const torch::Tensor rows = anchors.detach().reshape({-1, 3});
  return (scene.closest(rows).points - rows).view(anchors.sizes());
}

}  // namespace inhabit
