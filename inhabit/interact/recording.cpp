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

/// What somebody who sits or stands about does within a second of a frame, as far as they stay and no hand is at a
/// contact.
AheadPose ahead_pose(const Recording::Frame& now, const Recording::Frame& later) {
  AheadPose out;
  const bool stays = (now.seated && later.seated) || (stands(now) && stands(later));
  out.known = stays && !now.wanted[0] && !now.wanted[1];
  if (!out.known) return out;
  out.head = later.position[15];
  for (size_t side = 0; side < 2; ++side) {
    out.ankle[side] = later.position[7 + side];
    out.palm[side] = later.sample.hand[side];
    out.free[side] = !later.wanted[side];
  }
  return out;
}

}  // namespace

Recording record(const Clip& clip, const Labels& labels, const std::string& subject) {
  if (clip.skeleton.size() != kJoints || !clip.rotations.defined() || !clip.trans.defined())
    throw Error(subject, "needs rotations on the standard skeleton");
  Recording out;
  out.rate = clip.rate;
  out.bones = bones_of(clip.skeleton);
  const std::vector<Eigen::Quaterniond> rotations = global_rotations(pose_track(clip), clip.skeleton.parents);
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
      const Eigen::Matrix3f rotation = rotations[static_cast<size_t>(t * kJoints + j)].toRotationMatrix().cast<float>();
      const auto joint = static_cast<size_t>(j);
      f.position[joint] = {p[t][j][0], p[t][j][1], p[t][j][2]};
      f.forward[joint] = rotation.col(2);
      f.up[joint] = rotation.col(1);
      if (j == 20 || j == 21) f.sample.hand[joint - 20] = palm_of(f.position[joint], rotation, j - 20);
    }
    for (int side = 0; side < 2; ++side) {
      const auto s = static_cast<size_t>(side);
      f.contact[s] = {target[t][side][0], target[t][side][1], target[t][side][2]};
      f.wanted[s] = target[t][side][3] > 0.5F;
    }
    f.seated = labels.seated.data_ptr<float>()[t] > 0.5F;
    f.touching = {c[t][0], c[t][21], c[t][20], std::max(c[t][8], c[t][11]), std::max(c[t][7], c[t][10])};
  }
  return out;
}

bool stands(const Recording::Frame& frame) {
  constexpr size_t kIdle = 0;  // of the actions
  constexpr float kSure = 0.9F;
  return !frame.seated && frame.sample.action[kIdle] > kSure && frame.sample.goal_action[kIdle] > kSure;
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
  out.ahead = ahead_pose(now, at(frame + kSamples - 1 - kNow));
  return out;
}

State state_after(const Clip& motion, const std::string& subject) {
  constexpr int kLately = 5;  // frames
  const Recording recording = record(motion, label(motion, {}), subject);
  State out = state_at(recording, recording.size() - 1);
  const Sample now = out.now(), before = out.samples[kNow - kLately];
  const bool walks = now.action[1] > 0.5F;
  // The phase is known up to the last foothold, and rests from there: it goes on at the pace before.
  int known = kNow;
  while (known > 1 &&
         out.samples[static_cast<size_t>(known)].phase <= out.samples[static_cast<size_t>(known) - 1].phase)
    --known;
  const Sample last = out.samples[static_cast<size_t>(known)];
  const float pace = last.phase - out.samples[static_cast<size_t>(known) - 1].phase;
  const Vector2f step = (now.root.position - before.root.position) / kLately;
  for (int i = 0; i < kSamples; ++i) {
    Sample& s = out.samples[static_cast<size_t>(i)];
    const auto ahead = static_cast<float>(std::max(0, i - kNow));
    if (walks) {
      s.root.position += ahead * step;
      if (i > known) s.phase = last.phase + static_cast<float>(i - known) * pace;
      for (Vector3f& hand : s.hand) hand += ahead * Vector3f(step.x(), 0, step.y());
    }
    s.goal = now.root.origin();
    s.goal_facing = now.root.facing;
    s.goal_action = {1, 0, 0};
  }
  out.ahead = {};
  return out;
}

Scene mirrored(const Scene& scene) {
  const auto mirrored_points = [](const torch::Tensor& points) { return points * torch::tensor({-1.F, 1.F, 1.F}); };
  Scene out = scene;
  for (Mesh& mesh : out.meshes) {
    mesh.vertices = mirrored_points(mesh.vertices);
    mesh.faces = mesh.faces.flip(1);  // outside stays outside
  }
  if (scene.points.defined()) out.points = mirrored_points(scene.points);
  return out;
}

}  // namespace inhabit::interact
