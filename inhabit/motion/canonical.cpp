#include "inhabit/motion/canonical.h"

#include <cmath>

#include "inhabit/error.h"
#include "inhabit/math/quaternion.h"

namespace inhabit {
namespace {

// Points (..., 3) moved by `by`.
torch::Tensor moved(const torch::Tensor& points, const Eigen::Isometry3d& by) {
  torch::Tensor matrix = torch::empty({3, 3}, torch::kDouble), shift = torch::empty({3}, torch::kDouble);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) matrix[r][c] = by.linear()(r, c);
    shift[r] = by.translation()[r];
  }
  return (torch::matmul(points.to(torch::kDouble), matrix.t()) + shift).to(points.dtype());
}

// Axis-angle (T, 3) after a turn about the vertical.
torch::Tensor turned(const torch::Tensor& axis_angle, double yaw) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()));
  torch::Tensor out = axis_angle.to(torch::kCPU, torch::kDouble).contiguous().clone();
  for (double *p = out.data_ptr<double>(), *end = p + out.numel(); p < end; p += 3) {
    Eigen::Map<Eigen::Vector3d> v(p);
    v = axis_angle_of(turn * quaternion_of(v));
  }
  return out.to(axis_angle.dtype());
}

}  // namespace

Eigen::Isometry3d GroundTransform::isometry() const {
  Eigen::Isometry3d out(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()));
  out.pretranslate(shift);
  return out;
}

GroundTransform GroundTransform::inverse() const {
  const Eigen::AngleAxisd back(-yaw, Eigen::Vector3d::UnitY());
  return {-yaw, -(back * shift)};
}

double facing(const Clip& clip, int64_t frame) {
  const Skeleton& skeleton = clip.skeleton;
  const auto across = [&](const char* left, const char* right) {
    const int l = skeleton.find(left), r = skeleton.find(right);
    Eigen::Vector3d line = Eigen::Vector3d::Zero();
    if (l < 0 || r < 0) return line;
    const torch::Tensor d = (clip.joints[frame][l] - clip.joints[frame][r]).to(torch::kDouble).contiguous();
    line = Eigen::Map<const Eigen::Vector3d>(d.data_ptr<double>());
    return line;
  };
  const Eigen::Vector3d left = across("left_hip", "right_hip") + across("left_shoulder", "right_shoulder");
  if (std::hypot(left.x(), left.z()) > 1e-6) return std::atan2(-left.z(), left.x());  // left x up is forwards
  if (!clip.rotations.defined())
    throw Error("motion",
                "which way the person faces cannot be told: neither hips and shoulders nor rotations are known");
  const torch::Tensor r = clip.rotations[frame][0].to(torch::kDouble).contiguous();
  const Eigen::Vector3d forward =
      quaternion_of(Eigen::Map<const Eigen::Vector3d>(r.data_ptr<double>())) * Eigen::Vector3d::UnitZ();
  return std::atan2(forward.x(), forward.z());
}

GroundTransform canonical_transform(const Clip& clip, int64_t frame) {
  if (frame < 0 || frame >= clip.frames())
    throw Error("motion", "has no frame " + std::to_string(frame) + " (" + std::to_string(clip.frames()) + " frames)");
  GroundTransform out;
  out.yaw = -facing(clip, frame);
  const torch::Tensor r = clip.joints[frame][0].to(torch::kDouble).contiguous();
  const Eigen::Vector3d root(r.data_ptr<double>()[0], 0, r.data_ptr<double>()[2]);
  out.shift = -(Eigen::AngleAxisd(out.yaw, Eigen::Vector3d::UnitY()) * root);
  return out;
}

Clip transformed(const Clip& clip, const GroundTransform& by) {
  const Eigen::Isometry3d isometry = by.isometry();
  Clip out = clip;
  if (clip.joints.defined()) out.joints = moved(clip.joints, isometry);
  if (clip.rotations.defined()) {
    out.rotations = clip.rotations.clone();
    out.rotations.select(1, 0).copy_(turned(clip.rotations.select(1, 0), by.yaw));
  }
  if (clip.trans.defined()) {
    // The root turns about itself: its rest place is no part of the turn.
    const torch::Tensor rest = clip.skeleton.offsets[0];
    out.trans = moved(clip.trans + rest, isometry) - rest;
  }
  if (clip.hand_targets.defined())
    out.hand_targets =
        torch::cat({moved(clip.hand_targets.slice(2, 0, 3), isometry), clip.hand_targets.slice(2, 3)}, 2);
  if (clip.object_pose.defined() && clip.object_pose.size(1) > 0)
    out.object_pose = torch::cat({moved(clip.object_pose.slice(2, 0, 3), isometry),
                                  turned(clip.object_pose.slice(2, 3).reshape({-1, 3}), by.yaw)
                                      .reshape({clip.object_pose.size(0), clip.object_pose.size(1), 3})},
                                 2);
  return out;
}

}  // namespace inhabit
