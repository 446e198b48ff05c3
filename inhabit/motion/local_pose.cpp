#include "inhabit/motion/local_pose.h"

#include "inhabit/body/kinematics.h"
#include "inhabit/math/rotation.h"

namespace inhabit {

using torch::Tensor;

namespace {

/// Points (..., J, 3) rotated about the vertical by `yaw` (...), from +Z towards +X.
Tensor rotated(const Tensor& points, const Tensor& yaw) {
  return torch::matmul(points, yaw_matrix(yaw).transpose(-1, -2));
}

}  // namespace

Tensor local_poses(const Tensor& joints) { return rotated(joints - joints.narrow(-2, 0, 1), -headings(joints)); }

Tensor root_motion(const Tensor& joints) {
  const Tensor root = joints.select(-2, 0), yaw = headings(joints);  // (..., T, 3), (..., T)
  const int64_t frames = root.size(-2);
  const Tensor before = yaw.narrow(-1, 0, frames - 1);
  const Tensor step =
      rotated((root.narrow(-2, 1, frames - 1) - root.narrow(-2, 0, frames - 1)).unsqueeze(-2), -before).squeeze(-2);
  const Tensor change = yaw.narrow(-1, 1, frames - 1) - before;
  Tensor out = torch::zeros_like(root.select(-1, 0)).unsqueeze(-1).repeat_interleave(4, -1);
  const Tensor later = out.narrow(-2, 1, frames - 1);
  later.select(-1, 0).copy_(step.select(-1, 0));
  later.select(-1, 1).copy_(step.select(-1, 2));
  later.select(-1, 2).copy_(torch::atan2(change.sin(), change.cos()));
  out.select(-1, 3).copy_(root.select(-1, 1));
  return out;
}

Tensor placed_poses(const Tensor& poses, const Tensor& motion, const Tensor& root, const Tensor& heading) {
  const Tensor yaw = heading.unsqueeze(-1) + motion.select(-1, 2).cumsum(-1);  // (..., T)
  const Tensor before = yaw - motion.select(-1, 2);
  const Tensor flat = torch::zeros_like(yaw);
  const Tensor step =
      rotated(torch::stack({motion.select(-1, 0), flat, motion.select(-1, 1)}, -1).unsqueeze(-2), before).squeeze(-2);
  const Tensor path = step.cumsum(-2) + root.unsqueeze(-2);
  const Tensor place = torch::stack({path.select(-1, 0), motion.select(-1, 3), path.select(-1, 2)}, -1);
  return rotated(poses, yaw) + place.unsqueeze(-2);
}

Clip on_skeleton(const Clip& clip, const Skeleton& skeleton) {
  const auto leg = [](const Skeleton& s) {
    return (s.offsets[4].norm() + s.offsets[7].norm()).item<double>();  // knee and ankle
  };
  Clip out = clip;
  out.skeleton = skeleton;
  out.translations = torch::Tensor();
  const Tensor rest = clip.skeleton.offsets[0], new_rest = skeleton.offsets[0];
  out.trans = (clip.trans + rest) * (leg(skeleton) / leg(clip.skeleton)) - new_rest;
  out.joints = joint_positions(skeleton, clip.rotations, out.trans);
  return out;
}

}  // namespace inhabit
