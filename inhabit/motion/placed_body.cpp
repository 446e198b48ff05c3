#include "inhabit/motion/placed_body.h"

#include <cmath>

#include "inhabit/body/capsules.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/math/rotation.h"

namespace inhabit {

using torch::Tensor;

Tensor skin_points(const Clip& clip, const BodyModel& body) {
  if (!clip.rotations.defined()) throw Error("a body in a scene needs a motion with joint rotations");
  const torch::NoGradGuard no_gradients;
  const Tensor trans = clip.root_path() - shaped_skeleton(body, clip.betas).offsets[0];
  return skin(body, clip.betas, axis_angle_to_matrix(clip.rotations), trans);
}

Tensor anchor_points(const Clip& clip, const BodyModel& body) {
  BodyModel anchors = body;  // tensors are shared; only what the skin is made of is cut down
  anchors.template_vertices = body.template_vertices.index_select(0, body.anchors);
  anchors.shape_dirs = body.shape_dirs.index_select(0, body.anchors);
  anchors.skin_weights = body.skin_weights.index_select(0, body.anchors);
  if (body.pose_dirs.defined()) anchors.pose_dirs = body.pose_dirs.index_select(0, body.anchors);
  return skin_points(clip, anchors);
}

CapsulePoints capsule_points(const Clip& clip, const BodyModel& body, double spacing) {
  if (!clip.rotations.defined() || !clip.trans.defined()) throw Error("capsules need a clip with joint rotations");
  const Pose pose = forward_kinematics(clip.skeleton.parents, clip.skeleton.offsets,
                                       axis_angle_to_matrix(clip.rotations), clip.trans);
  CapsulePoints out;
  out.first.push_back(0);
  std::vector<Tensor> points;
  for (const Capsule& c : shaped_capsules(body, clip.betas)) {
    if (c.joint >= clip.skeleton.size()) continue;
    const Tensor a = torch::tensor({c.a[0], c.a[1], c.a[2]}), b = torch::tensor({c.b[0], c.b[1], c.b[2]});
    const int64_t n = 1 + static_cast<int64_t>(std::ceil((b - a).norm().item<double>() / spacing));
    const Tensor own = a + torch::linspace(0, 1, n).unsqueeze(1) * (b - a);  // (n, 3)
    const Tensor rotated = torch::matmul(pose.rotations.select(1, c.joint), own.t()).transpose(1, 2);
    points.push_back(rotated + pose.positions.select(1, c.joint).unsqueeze(1));
    out.first.push_back(out.first.back() + n);
    out.radii.push_back(c.radius);
    out.joints.push_back(c.joint);
  }
  out.points = torch::cat(points, 1);
  return out;
}

}  // namespace inhabit
