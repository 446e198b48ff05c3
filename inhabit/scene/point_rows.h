#pragma once
#include <torch/types.h>

#include <Eigen/Core>
#include <vector>

namespace inhabit {

/// Points as SceneQuery takes them: (N, 3) float.
torch::Tensor point_rows(const std::vector<Eigen::Vector3d>& points);

/// Row `i` of what SceneQuery answers with: (N, 3) float, contiguous.
Eigen::Vector3d row_point(const torch::Tensor& rows, size_t i);

}  // namespace inhabit
