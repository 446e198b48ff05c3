#include "inhabit/scene/contact_map.h"

#include "inhabit/error.h"

namespace inhabit {
namespace {

void check_shapes(const torch::Tensor& joints, const torch::Tensor& points) {
  if (joints.dim() < 2 || joints.size(-1) != 3) throw Error("joints must be (..., J, 3)");
  const bool batched = points.dim() == 3;
  if ((points.dim() != 2 && !batched) || points.size(-1) != 3) throw Error("scene points must be (N, 3) or (B, N, 3)");
  if (batched && (joints.dim() < 3 || joints.size(0) != points.size(0))) {
    throw Error("joints and scene points must have the same batch size");
  }
}

}  // namespace

torch::Tensor distance_map(const torch::Tensor& joints, const torch::Tensor& points) {
  check_shapes(joints, points);
  std::vector<int64_t> shape = joints.sizes().vec();
  shape.back() = points.size(-2);
  // Distances one by one (mode 2): through dot products (x - p)^2 loses half its digits near contact.
  if (points.dim() == 2) return torch::cdist(joints.reshape({-1, 3}), points, 2.0, 2).view(shape);
  return torch::cdist(joints.reshape({joints.size(0), -1, 3}), points, 2.0, 2).view(shape);
}

torch::Tensor contact_map(const torch::Tensor& joints, const torch::Tensor& points, double sigma) {
  return torch::exp(distance_map(joints, points).square() * (-0.5 / (sigma * sigma)));
}

}  // namespace inhabit
