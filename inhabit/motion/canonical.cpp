#include "inhabit/motion/canonical.h"

#include <cmath>

#include "inhabit/error.h"
#include "inhabit/math/heading.h"
#include "inhabit/math/rotation.h"

namespace inhabit {
namespace {

// Points (..., 3) moved by `by`.
torch::Tensor moved(const torch::Tensor& points, const GroundTransform& by) {
  const torch::Tensor rotation = yaw_matrix(torch::tensor(by.yaw, torch::kDouble));
  const torch::Tensor shift = torch::tensor({by.shift.x(), by.shift.y(), by.shift.z()}, torch::kDouble);
  return (torch::matmul(points.to(torch::kDouble), rotation.t()) + shift).to(points.dtype());
}

// Axis-angle (..., 3) after a rotation about the vertical.
torch::Tensor rotated(const torch::Tensor& axis_angle, double yaw) {
  const torch::Tensor rotation = yaw_matrix(torch::tensor(yaw, torch::kDouble));
  return matrix_to_axis_angle(torch::matmul(rotation, axis_angle_to_matrix(axis_angle.to(torch::kDouble))))
      .to(axis_angle.dtype());
}

}  // namespace

GroundTransform GroundTransform::inverse() const {
  const Eigen::AngleAxisd back(-yaw, Eigen::Vector3d::UnitY());
  return {-yaw, -(back * shift)};
}

torch::Tensor headings(const torch::Tensor& joints) {
  const auto joint = [&](int64_t j) { return joints.select(-2, j); };
  return yaw_of_left(right_to_left(joint(1), joint(2), joint(16), joint(17)));
}

double heading(const Clip& clip, int64_t frame) {
  const torch::Tensor joints = clip.joints[frame].to(torch::kDouble);
  torch::Tensor left = torch::zeros({3}, torch::kDouble);
  for (const std::string part : {"hip", "shoulder"}) {
    const int l = clip.skeleton.find("left_" + part), r = clip.skeleton.find("right_" + part);
    if (l >= 0 && r >= 0) left = left + (joints[l] - joints[r]);
  }
  if (std::hypot(left[0].item<double>(), left[2].item<double>()) > 1e-6) return yaw_of_left(left).item<double>();
  if (!clip.rotations.defined())
    throw Error("motion",
                "which way the person faces cannot be told: neither hips and shoulders nor rotations are known");
  const torch::Tensor ahead = axis_angle_to_matrix(clip.rotations[frame][0].to(torch::kDouble)).select(1, 2);
  return heading_of({ahead[0].item<double>(), ahead[2].item<double>()});
}

GroundTransform canonical_transform(const Clip& clip, int64_t frame) {
  if (frame < 0 || frame >= clip.frames())
    throw Error("motion", "has no frame " + std::to_string(frame) + " (" + std::to_string(clip.frames()) + " frames)");
  GroundTransform out;
  out.yaw = -heading(clip, frame);
  const torch::Tensor r = clip.joints[frame][0].to(torch::kDouble).contiguous();
  const Eigen::Vector3d root(r.data_ptr<double>()[0], 0, r.data_ptr<double>()[2]);
  out.shift = -(Eigen::AngleAxisd(out.yaw, Eigen::Vector3d::UnitY()) * root);
  return out;
}

Clip transformed(const Clip& clip, const GroundTransform& by) {
  Clip out = clip;
  if (clip.joints.defined()) out.joints = moved(clip.joints, by);
  if (clip.rotations.defined()) {
    out.rotations = clip.rotations.clone();
    out.rotations.select(1, 0).copy_(rotated(clip.rotations.select(1, 0), by.yaw));
  }
  if (clip.trans.defined()) {
    // The rotation is about the root joint itself: where it rests is no part of it.
    const torch::Tensor rest = clip.skeleton.offsets[0];
    out.trans = moved(clip.trans + rest, by) - rest;
  }
  if (clip.hand_targets.defined())
    out.hand_targets = torch::cat({moved(clip.hand_targets.slice(2, 0, 3), by), clip.hand_targets.slice(2, 3)}, 2);
  if (clip.object_pose.defined() && clip.object_pose.size(1) > 0)
    out.object_pose =
        torch::cat({moved(clip.object_pose.slice(2, 0, 3), by), rotated(clip.object_pose.slice(2, 3), by.yaw)}, 2);
  return out;
}

}  // namespace inhabit
