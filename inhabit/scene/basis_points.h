#pragma once
#include "inhabit/scene/query.h"

namespace inhabit {

/// Basis-point offsets (Prokudin et al. 2019): from every anchor, a point on the body, to the nearest point of the
/// scene.
/// @param anchors (..., A, 3) metres, world: BodyModel has A = 64. Returns (..., A, 3) metres, world axes.
torch::Tensor basis_point_offsets(const SceneQuery& scene, const torch::Tensor& anchors);

}  // namespace inhabit
