#include "inhabit/interact/recording.h"

#include <algorithm>

#include "inhabit/error.h"
#include "inhabit/math/heading.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/motion/pose_track.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

/// Index of the joint on the other side, of every joint of the standard skeleton.
torch::Tensor other_sides() {
  std::vector<int64_t> out;
  const std::vector<std::string>& names = standard_joint_names();
  for (const std::string& name : names) {
    std::string other = name;
    if (name.rfind("left_", 0) == 0) other = "right_" + name.substr(5);
    if (name.rfind("right_", 0) == 0) other = "left_" + name.substr(6);
    out.push_back(std::find(names.begin(), names.end(), other) - names.begin());
  }
  return torch::tensor(out);
}

/// Points (..., 3), or what else has its first number change sign.
torch::Tensor mirrored_points(const torch::Tensor& points) {
  torch::Tensor out = points.clone();
  out.select(-1, 0).neg_();
  return out;
}

/// Axis-angle (..., 3) of the mirrored rotation.
torch::Tensor mirrored_turns(const torch::Tensor& turns) {
  torch::Tensor out = turns.clone();
  out.slice(-1, 1, 3).neg_();
  return out;
}

Sample sample_of(const Labels& labels, int64_t t, const Vector2f& position, double heading) {
  Sample s;
  s.root = {position, ahead_of(heading).cast<float>()};
  const float *action = labels.action.data_ptr<float>() + 3 * t, *goal = labels.goal.data_ptr<float>() + 3 * t,
              *direction = labels.goal_direction.data_ptr<float>() + 3 * t,
              *intended = labels.goal_action.data_ptr<float>() + 3 * t,
              *hand = labels.hand_phase.data_ptr<float>() + 2 * t;
  std::copy(action, action + 3, s.action.begin());
  std::copy(intended, intended + 3, s.goal_action.begin());
  s.goal = {goal[0], goal[1], goal[2]};
  s.goal_facing = {direction[0], direction[2]};
  s.phase = labels.global_phase.data_ptr<float>()[t];
  s.hand_phase = {hand[0], hand[1]};
  return s;
}

}  // namespace

Recording record(const Clip& clip, const Labels& labels, const std::string& subject) {
  if (clip.skeleton.size() != kJoints || !clip.rotations.defined() || !clip.trans.defined())
    throw Error(subject, "needs rotations on the standard skeleton");
  Recording out;
  out.rate = clip.rate;
  out.bones = bones_of(clip.skeleton);
  const std::vector<Eigen::Quaterniond> turns = global_rotations(pose_track(clip), clip.skeleton.parents);
  const torch::Tensor joints = clip.joints.to(torch::kFloat).contiguous(),
                      yaw = headings(clip.joints.to(torch::kDouble)).contiguous(),
                      contact = clip.contact.defined() ? clip.contact.to(torch::kFloat).contiguous()
                                                       : torch::zeros({clip.frames(), kJoints});
  const auto p = joints.accessor<float, 3>();
  const auto c = contact.accessor<float, 2>();
  const auto target = labels.hand_target.accessor<float, 3>();
  out.frames.resize(static_cast<size_t>(clip.frames()));
  for (int64_t t = 0; t < clip.frames(); ++t) {
    Recording::Frame& f = out.frames[static_cast<size_t>(t)];
    f.sample = sample_of(labels, t, {p[t][0][0], p[t][0][2]}, yaw.data_ptr<double>()[t]);
    for (int j = 0; j < kJoints; ++j) {
      const Eigen::Matrix3f turn = turns[static_cast<size_t>(t * kJoints + j)].toRotationMatrix().cast<float>();
      const auto joint = static_cast<size_t>(j);
      f.position[joint] = {p[t][j][0], p[t][j][1], p[t][j][2]};
      f.forward[joint] = turn.col(2);
      f.up[joint] = turn.col(1);
      if (j == 20 || j == 21) f.sample.hand[joint - 20] = palm_of(f.position[joint], turn, j - 20);
    }
    for (int side = 0; side < 2; ++side) {
      const auto s = static_cast<size_t>(side);
      f.contact[s] = {target[t][side][0], target[t][side][1], target[t][side][2]};
      f.wanted[s] = target[t][side][3] > 0.5F;
    }
    f.touching = {c[t][0], c[t][21], c[t][20], std::max(c[t][8], c[t][11]), std::max(c[t][7], c[t][10])};
  }
  return out;
}

State state_at(const Recording& recording, int64_t frame) {
  const auto at = [&](int64_t t) -> const Recording::Frame& {
    return recording.frames[static_cast<size_t>(std::clamp<int64_t>(t, 0, recording.size() - 1))];
  };
  State out;
  const Recording::Frame &now = at(frame), &before = at(frame - 1);
  for (int i = 0; i < kSamples; ++i) out.samples[static_cast<size_t>(i)] = at(frame + i - kNow).sample;
  for (size_t j = 0; j < kJoints; ++j) {
    out.position[j] = now.position[j];
    out.velocity[j] = (now.position[j] - before.position[j]) * static_cast<float>(recording.rate);
    out.rotation[j].col(0) = now.up[j].cross(now.forward[j]);
    out.rotation[j].col(1) = now.up[j];
    out.rotation[j].col(2) = now.forward[j];
  }
  out.position_from_ahead = now.position;
  out.touching = now.touching;
  out.contact = now.contact;
  out.wanted = now.wanted;
  return out;
}

Clip mirrored(const Clip& clip) {
  static const torch::Tensor other = other_sides();
  static const torch::Tensor hands = torch::tensor({int64_t{1}, int64_t{0}});
  Clip out = clip;
  out.skeleton.offsets = mirrored_points(clip.skeleton.offsets.index_select(0, other));
  out.joints = mirrored_points(clip.joints.index_select(1, other));
  if (clip.rotations.defined()) out.rotations = mirrored_turns(clip.rotations.index_select(1, other));
  if (clip.trans.defined()) out.trans = mirrored_points(clip.trans);
  if (clip.translations.defined()) out.translations = mirrored_points(clip.translations.index_select(1, other));
  if (clip.contact.defined()) out.contact = clip.contact.index_select(1, other);
  if (clip.hand_targets.defined()) out.hand_targets = mirrored_points(clip.hand_targets.index_select(1, hands));
  if (clip.object_pose.defined())
    out.object_pose =
        torch::cat({mirrored_points(clip.object_pose.slice(2, 0, 3)), mirrored_turns(clip.object_pose.slice(2, 3))}, 2);
  return out;
}

Scene mirrored(const Scene& scene) {
  Scene out = scene;
  for (Mesh& mesh : out.meshes) {
    mesh.vertices = mirrored_points(mesh.vertices);
    mesh.faces = mesh.faces.flip(1);  // outside stays outside
  }
  if (scene.points.defined()) out.points = mirrored_points(scene.points);
  return out;
}

}  // namespace inhabit::interact
