#include "inhabit/body/capsules.h"

#include <algorithm>
#include <cmath>

namespace inhabit {
namespace {

using Eigen::Vector3d;

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

void place_capsules(const std::vector<Capsule>& capsules, const BonesPose& pose, std::vector<WorldCapsule>& out) {
  out.resize(capsules.size());
  for (size_t i = 0; i < capsules.size(); ++i) {
    const Capsule& c = capsules[i];
    const Eigen::Quaterniond& turn = pose.rotations[c.joint];
    const Vector3d& place = pose.positions[c.joint];
    out[i] = {c.joint, place + turn * Vector3d(c.a[0], c.a[1], c.a[2]), place + turn * Vector3d(c.b[0], c.b[1], c.b[2]),
              c.radius};
  }
}

double capsule_distance(const WorldCapsule& first, const WorldCapsule& second) {
  // Closest points of two segments (Ericson, Real-Time Collision Detection, 5.1.9).
  const Vector3d d1 = first.b - first.a, d2 = second.b - second.a, r = first.a - second.a;
  const double a = d1.squaredNorm(), e = d2.squaredNorm(), f = d2.dot(r), c = d1.dot(r), b = d1.dot(d2);
  double s = 0, t = 0;
  if (a > 1e-12) {
    const double denominator = a * e - b * b;
    s = denominator > 1e-12 ? std::clamp((b * f - c * e) / denominator, 0.0, 1.0) : 0.0;
    if (e <= 1e-12) s = std::clamp(-c / a, 0.0, 1.0);
  }
  if (e > 1e-12) {
    t = (b * s + f) / e;
    if (t < 0 || t > 1) {
      t = std::clamp(t, 0.0, 1.0);
      if (a > 1e-12) s = std::clamp((b * t - c) / a, 0.0, 1.0);
    }
  }
  return (first.a + s * d1 - second.a - t * d2).norm() - first.radius - second.radius;
}

}  // namespace inhabit
