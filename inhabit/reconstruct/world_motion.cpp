#include "inhabit/reconstruct/world_motion.h"

#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"

namespace inhabit::reconstruct {
namespace {

using Eigen::Vector3d;

Vector3d row_of(const torch::TensorAccessor<float, 1>& row) { return {row[0], row[1], row[2]}; }

void set_row(torch::TensorAccessor<float, 1> row, const Vector3d& value) {
  for (int i = 0; i < 3; ++i) row[i] = static_cast<float>(value[i]);
}

}  // namespace

Clip in_world(const Clip& motion, const Camera& camera, const std::string& subject) {
  if (!motion.rotations.defined() || !motion.trans.defined()) throw Error(subject, "holds no joint rotations");
  if (camera.moves() && static_cast<int64_t>(camera.to_world.size()) != motion.frames())
    throw Error(subject, "has " + std::to_string(motion.frames()) + " frames, but the camera has poses of " +
                             std::to_string(camera.to_world.size()));
  Clip out = person_of(motion);
  out.rotations = motion.rotations.to(torch::kFloat32).clone();
  out.trans = motion.trans.to(torch::kFloat32).clone();
  out.translations = motion.translations;
  const torch::Tensor offset_row = motion.skeleton.offsets[0].to(torch::kFloat32).contiguous();
  const Vector3d offset = row_of(offset_row.accessor<float, 1>());
  auto rotations = out.rotations.accessor<float, 3>();
  auto trans = out.trans.accessor<float, 2>();
  for (int64_t t = 0; t < motion.frames(); ++t) {
    Eigen::Isometry3d move = Eigen::Isometry3d::Identity();
    move.linear() = camera.upright.toRotationMatrix();
    if (camera.motion_in_camera) move = camera.pose(t);
    if (move.isApprox(Eigen::Isometry3d::Identity(), 1e-12)) continue;
    const Vector3d axis = row_of(rotations[t][0]);
    const Eigen::Matrix3d root = axis.norm() > 1e-12
                                     ? Eigen::AngleAxisd(axis.norm(), axis.normalized()).toRotationMatrix()
                                     : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
    const Eigen::AngleAxisd rotated(Eigen::Matrix3d(move.linear() * root));
    set_row(rotations[t][0], rotated.angle() * rotated.axis());
    set_row(trans[t], move * (row_of(trans[t]) + offset) - offset);
  }
  out.joints = joint_positions(out.skeleton, out.rotations, out.trans, out.translations);
  return out;
}

Clip with_roots_moved(const Clip& motion, const std::vector<int64_t>& keys, const std::vector<Vector3d>& moved) {
  Clip out = motion;
  torch::Tensor by = torch::zeros_like(motion.trans);
  auto row = by.accessor<float, 2>();
  for (size_t k = 0; k < keys.size(); ++k) {
    const int64_t from = keys[k], to = k + 1 < keys.size() ? keys[k + 1] : from;
    for (int64_t t = from; t <= to; ++t) {
      const double part = to > from ? static_cast<double>(t - from) / static_cast<double>(to - from) : 0;
      const Vector3d& next = moved[std::min(k + 1, keys.size() - 1)];
      set_row(row[t], (1 - part) * moved[k] + part * next);
    }
  }
  out.trans = motion.trans + by;
  out.joints = motion.joints + by.unsqueeze(1);
  return out;
}

}  // namespace inhabit::reconstruct
