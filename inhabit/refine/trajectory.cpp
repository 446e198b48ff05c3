#include "inhabit/refine/trajectory.h"

#include <algorithm>

#include "inhabit/math/quaternion.h"

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;

bool same(const FramePose& a, const FramePose& b) {
  for (size_t j = 0; j < a.local.size(); ++j)
    if (a.local[j].coeffs() != b.local[j].coeffs()) return false;
  return a.trans == b.trans;
}

}  // namespace

Trajectory trajectory_of(const Clip& clip) {
  const torch::Tensor trans = clip.trans.to(torch::kCPU, torch::kFloat64).contiguous(),
                      rotations = clip.rotations.to(torch::kCPU, torch::kFloat64).contiguous();
  const double *x = trans.data_ptr<double>(), *r = rotations.data_ptr<double>();
  Trajectory out(static_cast<size_t>(clip.frames()));
  for (FramePose& pose : out) {
    pose.trans = Vector3d(x[0], x[1], x[2]);
    x += 3;
    for (int j = 0; j < clip.skeleton.size(); ++j, r += 3)
      pose.local.push_back(quaternion_of(Vector3d(r[0], r[1], r[2])));
  }
  return out;
}

Poses posed(const Bones& bones, const Trajectory& trajectory) {
  Poses out(trajectory.size());
  for (size_t t = 0; t < trajectory.size(); ++t) pose_bones(bones, trajectory[t].local, trajectory[t].trans, out[t]);
  return out;
}

Track track_of(const Poses& poses, int joint) {
  Track out;
  for (const BonesPose& pose : poses) out.push_back(pose.positions[static_cast<size_t>(joint)]);
  return out;
}

Clip clip_of(const Trajectory& trajectory, const Clip& like) {
  Clip out = like;
  out.rotations = like.rotations.clone();
  out.trans = like.trans.clone();
  out.joints = like.joints.clone();
  const Trajectory before = trajectory_of(like);
  const Poses poses = posed(bones_of(like.skeleton), trajectory);
  auto r = out.rotations.accessor<float, 3>();
  auto x = out.trans.accessor<float, 2>();
  auto p = out.joints.accessor<float, 3>();
  for (size_t t = 0; t < trajectory.size(); ++t) {
    if (same(trajectory[t], before[t])) continue;
    const auto frame = static_cast<int64_t>(t);
    for (int64_t j = 0; j < like.skeleton.size(); ++j) {
      const Vector3d rotation = axis_angle_of(trajectory[t].local[j]);
      for (int i = 0; i < 3; ++i) {
        r[frame][j][i] = static_cast<float>(rotation[i]);
        p[frame][j][i] = static_cast<float>(poses[t].positions[j][i]);
      }
    }
    for (int i = 0; i < 3; ++i) x[frame][i] = static_cast<float>(trajectory[t].trans[i]);
  }
  return out;
}

}  // namespace inhabit::refine
