#include "inhabit/body/capsules.h"

#include <algorithm>
#include <cmath>

namespace inhabit {
namespace {

/// Mean distance of each joint's own skin from the joint, (J); 0 where a joint has no skin of its own.
torch::Tensor flesh_sizes(const BodyModel& model, const torch::Tensor& vertices, const torch::Tensor& joints) {
  const torch::Tensor own = (model.skin_weights > 0.5).to(torch::kFloat);
  const torch::Tensor distance = (vertices.unsqueeze(1) - joints.unsqueeze(0)).norm(2, -1);  // (V, J)
  return (own * distance).sum(0) / own.sum(0).clamp_min(1);
}

}  // namespace

std::vector<Capsule> shaped_capsules(const BodyModel& model, const torch::Tensor& betas) {
  if (!betas.defined() || betas.numel() == 0) return model.capsules;
  const torch::NoGradGuard no_gradient;
  const torch::Tensor joints = shaped_skeleton(model, betas).rest_joints();  // checks betas
  const torch::Tensor b = betas.to(model.shape_dirs.options());
  const torch::Tensor vertices = model.template_vertices + model.shape_dirs.narrow(2, 0, b.size(0)).matmul(b);
  const torch::Tensor mean = flesh_sizes(model, model.template_vertices, model.joint_template);
  const torch::Tensor growth = flesh_sizes(model, vertices, joints) / mean.clamp_min(1e-6);
  std::vector<Capsule> capsules = model.capsules;
  for (Capsule& c : capsules) {
    if (mean[c.joint].item<float>() <= 0) continue;
    const float scale = growth[c.joint].item<float>();
    for (int i = 0; i < 3; ++i) {
      c.a[i] *= scale;
      c.b[i] *= scale;
    }
    c.radius *= scale;
  }
  return capsules;
}

}  // namespace inhabit
