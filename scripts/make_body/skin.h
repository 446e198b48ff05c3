#pragma once
#include <torch/types.h>

#include "polygonise.h"

namespace inhabit {

/// The built-in body's skin at rest in the pelvis frame, metres: closed, mirror symmetric, about 3700 vertices.
TriangleSurface builtin_skin();

/// (V, 22) linear blend weights, rows sum to 1, at most four joints a vertex.
torch::Tensor builtin_skin_weights(const TriangleSurface& skin);

/// (V, 3, kBuiltinBetas) metres that each vertex moves with one unit of each shape parameter.
torch::Tensor builtin_shape_directions(const TriangleSurface& skin, const torch::Tensor& weights);

}  // namespace inhabit
