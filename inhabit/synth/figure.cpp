#include "inhabit/synth/figure.h"

#include <algorithm>
#include <cmath>

#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/math/rotation.h"

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
  figure.limits = joint_limits(model);
  figure.thigh = 0.5 * (offset[4].norm() + offset[5].norm());
  figure.shank = 0.5 * (offset[7].norm() + offset[8].norm());
  figure.upper_arm = 0.5 * (offset[18].norm() + offset[19].norm());
  figure.forearm = 0.5 * (offset[20].norm() + offset[21].norm());
  const Vector3d ankle = offset[1] + offset[4] + offset[7], ball = ankle + offset[10];
  figure.ankle_ahead = ankle.z();
  // Lengths that flesh decides are measured on the skin where the model has one.
  double sole = ball.y() - capsule_extent(model, 10, -Vector3d::UnitY(), 0.025);
  figure.heel_back = ball.z() - ankle.z() + 0.05;
  figure.toe_front = 0.075;
  figure.seat_depth = std::max(capsule_extent(model, 0, -Vector3d::UnitY(), 0.11), 0.0);
  figure.back_depth = capsule_extent(model, 0, -Vector3d::UnitZ(), 0.11);
  figure.thigh_depth = capsule_extent(model, 1, Vector3d::UnitX(), 0.075);
  figure.palm_depth = capsule_extent(model, 20, -Vector3d::UnitY(), 0.028);
  figure.palm_reach = 0.085;
  if (model.template_vertices.defined() && model.template_vertices.numel() > 0) {
    const torch::NoGradGuard no_gradient;
    // Rest for the feet; sitting for what one sits on.
    torch::Tensor rotations = torch::zeros({2, model.joints(), 3});
    for (int hip : {1, 2}) rotations[1][hip][0] = -M_PI / 2;
    for (int knee : {4, 5}) rotations[1][knee][0] = M_PI / 2;
    const torch::Tensor rest_root = skeleton.offsets[0];
    const torch::Tensor vertices =
        (skin(model, betas, axis_angle_to_matrix(rotations), torch::zeros({2, 3})) - rest_root)
            .to(torch::kDouble)
            .contiguous();
    const torch::Tensor weights = model.skin_weights.to(torch::kDouble).contiguous();
    const auto v = vertices.accessor<double, 3>();
    const auto w = weights.accessor<double, 2>();
    double lowest = 1e9, heel = 1e9, toe = -1e9, seat = 1e9, back = 1e9, palm = 1e9, thigh = 0;
    const Vector3d wrist = offset[13] + offset[16] + offset[18] + offset[20] + offset[3] + offset[6] + offset[9];
    for (int64_t i = 0; i < v.size(1); ++i) {
      lowest = std::min(lowest, v[0][i][1]);
      if (w[i][7] + w[i][10] > 0.7) heel = std::min(heel, v[0][i][2]), toe = std::max(toe, v[0][i][2]);
      if (w[i][0] + w[i][1] + w[i][2] > 0.9 && v[1][i][2] < 0.12) seat = std::min(seat, v[1][i][1]);
      if (w[i][0] > 0.6) back = std::min(back, v[1][i][2]);
      const double down = (v[0][i][1] - offset[1].y()) / offset[4].y();
      if (w[i][1] > 0.9 && down > 0.45 && down < 0.7)
        thigh = std::max(thigh, v[0][i][2] - offset[1].z() - down * offset[4].z());
      const double along = v[0][i][0] - wrist.x();
      if (w[i][20] > 0.8 && along > 0.05 && along < 0.12) palm = std::min(palm, v[0][i][1] - wrist.y());
    }
    sole = lowest;
    if (heel < ankle.z()) figure.heel_back = ball.z() - heel;
    if (toe > ball.z()) figure.toe_front = toe - ball.z();
    if (seat < 0) figure.seat_depth = -seat - 0.012;  // flesh gives way by a centimetre
    if (thigh > 0) figure.thigh_depth = thigh;
    if (back < 0) figure.back_depth = -back;
    // A hand that rests gives way by a few millimetres.
    if (palm < 0.05 && palm > -0.08) figure.palm_depth = -palm - 0.004;
  }
  figure.stand_height = -sole;
  figure.ball_height = ball.y() - sole;
  return figure;
}

}  // namespace inhabit
