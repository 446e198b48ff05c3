#include "inhabit/scene/point_rows.h"

namespace inhabit {

torch::Tensor point_rows(const std::vector<Eigen::Vector3d>& points) {
  torch::Tensor out = torch::empty({static_cast<int64_t>(points.size()), 3});
  float* p = out.data_ptr<float>();
  for (const Eigen::Vector3d& v : points)
    for (int i = 0; i < 3; ++i) *p++ = static_cast<float>(v[i]);
  return out;
}

Eigen::Vector3d row_point(const torch::Tensor& rows, size_t i) {
  return Eigen::Map<const Eigen::Vector3f>(rows.data_ptr<float>() + 3 * i).cast<double>();
}

}  // namespace inhabit
