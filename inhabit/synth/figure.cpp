#include "inhabit/synth/figure.h"

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"

namespace inhabit {

using Eigen::Vector3d;

namespace {

/// Reach of the capsules of `joint` along `direction` (joint frame) from the joint, metres.
double capsule_extent(const BodyModel& model, int joint, const Vector3d& direction, double otherwise) {
  double extent = -1;
  for (const Capsule& c : model.capsules) {
    if (c.joint != joint) continue;
    for (const auto& end : {c.a, c.b})
      extent = std::max(extent, Vector3d(end[0], end[1], end[2]).dot(direction) + c.radius);
  }
  return extent < 0 ? otherwise : extent;
}

}  // namespace

Figure make_figure(const BodyModel& model, const torch::Tensor& betas) {
  if (model.joints() < kStandardJoints) throw Error(model.name, "the body lacks the 22 standard joints");
  Figure figure;
  const Skeleton skeleton = shaped_skeleton(model, betas);
  figure.bones = bones_of(skeleton);
  figure.bones.parents.resize(kStandardJoints);
  figure.bones.offsets.resize(kStandardJoints);
  const auto& offset = figure.bones.offsets;
  figure.lowest.fill(Eigen::Array3d::Constant(-7));
  figure.highest.fill(Eigen::Array3d::Constant(7));
  if (model.joint_limits.defined()) {
    const torch::Tensor limits = model.joint_limits.to(torch::kCPU, torch::kDouble).contiguous();
    const auto a = limits.accessor<double, 3>();
    for (int j = 0; j < kStandardJoints; ++j)
      for (int i = 0; i < 3; ++i) figure.lowest[j][i] = a[j][i][0], figure.highest[j][i] = a[j][i][1];
  }
  figure.thigh = 0.5 * (offset[4].norm() + offset[5].norm());
  figure.shank = 0.5 * (offset[7].norm() + offset[8].norm());
  figure.upper_arm = 0.5 * (offset[18].norm() + offset[19].norm());
  figure.forearm = 0.5 * (offset[20].norm() + offset[21].norm());
  const Vector3d ankle = offset[1] + offset[4] + offset[7], ball = ankle + offset[10];
  figure.ankle_ahead = ankle.z();
  const double sole = ball.y() - capsule_extent(model, 10, -Vector3d::UnitY(), 0.025);
  figure.heel_back = ball.z() - ankle.z() + 0.05;
  figure.toe_front = 0.075;
  figure.seat_depth = std::max(capsule_extent(model, 0, -Vector3d::UnitY(), 0.11), 0.0);
  figure.back_depth = capsule_extent(model, 0, -Vector3d::UnitZ(), 0.11);
  figure.thigh_depth = capsule_extent(model, 1, Vector3d::UnitX(), 0.075);
  figure.palm_depth = capsule_extent(model, 20, -Vector3d::UnitY(), 0.028);
  figure.palm_reach = 0.085;
  figure.stand_height = -sole;
  figure.ball_height = ball.y() - sole;
  return figure;
}

}  // namespace inhabit
