#include "inhabit/body/capsules.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace inhabit {
namespace {

/// Mean distance of each joint's own skin from the joint, (J); 0 where a joint has no skin of its own.
std::vector<float> flesh_sizes(const BodyModel& model, const torch::Tensor& vertices, const torch::Tensor& joints) {
  const auto w = model.skin_weights.accessor<float, 2>();
  const auto v = vertices.accessor<float, 2>(), at = joints.accessor<float, 2>();
  std::vector<float> sum(static_cast<size_t>(w.size(1)), 0), count(sum.size(), 0);
  for (int64_t i = 0; i < w.size(0); ++i) {
    for (int64_t j = 0; j < w.size(1); ++j) {
      if (!(w[i][j] > 0.5F)) continue;
      sum[static_cast<size_t>(j)] += std::hypot(v[i][0] - at[j][0], v[i][1] - at[j][1], v[i][2] - at[j][2]);
      count[static_cast<size_t>(j)] += 1;
    }
  }
  for (size_t j = 0; j < sum.size(); ++j) sum[j] /= std::max(1.0F, count[j]);
  return sum;
}

}  // namespace

std::vector<Capsule> shaped_capsules(const BodyModel& model, const torch::Tensor& betas) {
  if (!betas.defined() || betas.numel() == 0) return model.capsules;
  const torch::NoGradGuard no_gradient;
  const torch::Tensor joints = shaped_skeleton(model, betas).rest_joints();  // checks betas
  const torch::Tensor b = betas.to(model.shape_dirs.options());
  const torch::Tensor vertices = model.template_vertices + model.shape_dirs.narrow(2, 0, b.size(0)).matmul(b);
  const std::vector<float> mean = flesh_sizes(model, model.template_vertices, model.joint_template),
                           own = flesh_sizes(model, vertices, joints);
  std::vector<Capsule> capsules = model.capsules;
  for (Capsule& c : capsules) {
    const auto joint = static_cast<size_t>(c.joint);
    if (mean[joint] <= 0) continue;
    const float scale = own[joint] / std::max(mean[joint], 1e-6F);
    for (int i = 0; i < 3; ++i) {
      c.a[i] *= scale;
      c.b[i] *= scale;
    }
    c.radius *= scale;
  }
  return capsules;
}

}  // namespace inhabit
