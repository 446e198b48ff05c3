#include "inhabit/inbetween/baseline.h"

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/inbetween/key_smoother.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/obstacle_detours.h"

namespace inhabit::inbetween {

using Eigen::Quaternionf;
using Eigen::Vector3f;

namespace {

std::vector<KeyDistance> distances_to(const std::vector<char>& constrained) {
  const int frames = static_cast<int>(constrained.size());
  std::vector<KeyDistance> out(constrained.size());
  for (int t = 0, last = -1; t < frames; ++t) {
    if (constrained[static_cast<size_t>(t)] != 0) last = t;
    if (last >= 0) out[static_cast<size_t>(t)].before = t - last;
  }
  for (int t = frames - 1, next = -1; t >= 0; --t) {
    if (constrained[static_cast<size_t>(t)] != 0) next = t;
    if (next >= 0) out[static_cast<size_t>(t)].after = next - t;
  }
  return out;
}

/// The constrained frames around frame t, and how far it is from the first to the second, 0 to 1.
struct Around {
  int64_t from, to;
  float part;
};
Around around(const KeyDistance& d, int64_t t) {
  if (d.before < 0) return {t + d.after, t + d.after, 0};
  if (d.after <= 0) return {t - d.before, t - d.before, 0};
  return {t - d.before, t + d.after, static_cast<float>(d.before) / static_cast<float>(d.before + d.after)};
}

/// Notes where a key has joint `j`, as seen from the baseline.
void put_target(Baseline& baseline, const Poses& keys, int64_t t, int64_t j) {
  const Eigen::AngleAxisf to_heading(-baseline.heading[static_cast<size_t>(t)], Vector3f::UnitY());
  const Vector3f away = to_heading * (keys.joints[Poses::at(t, j)] - baseline.poses.joints[Poses::at(t, j)]);
  auto target = baseline.targets.accessor<float, 3>();
  for (int axis = 0; axis < 3; ++axis) target[t][j][axis] = away[axis];
  target[t][j][3] = 1;
}

/// The baseline of keys as they are.
Baseline baseline_through(const Poses& keys, const torch::Tensor& groups, const torch::Tensor& detours) {
  const int64_t frames = keys.frames();
  const torch::Tensor plain = groups.to(torch::kFloat32).contiguous();
  const auto constrains = plain.accessor<float, 2>();
  std::vector<char> whole(static_cast<size_t>(frames)), rooted(whole.size());
  for (int64_t t = 0; t < frames; ++t) {
    whole[static_cast<size_t>(t)] = constrains[t][kBodyRotationsGroup] > 0 ? 1 : 0;
    rooted[static_cast<size_t>(t)] = constrains[t][kRootTranslationGroup] > 0 ? 1 : 0;
  }
  if (whole.empty() || whole[0] == 0 || rooted[0] == 0) throw Error("keys", "the first frame is no whole pose");
  Baseline out;
  out.pose_distance = distances_to(whole);
  out.root_distance = distances_to(rooted);
  out.poses.offsets = keys.offsets;
  out.poses.joints.resize(Poses::at(frames, 0));
  out.poses.rotations.resize(Poses::at(frames, 0));
  out.heading.resize(static_cast<size_t>(frames));
  out.noise.resize(static_cast<size_t>(frames), 0);
  std::vector<double> yaws(whole.size(), 0);
  std::vector<int64_t> root_keys;
  if (detours.defined()) {
    std::vector<Eigen::Vector2d> straight;
    for (int64_t t = 0; t < frames; ++t) {
      const Around root = around(out.root_distance[static_cast<size_t>(t)], t);
      const Vector3f place = keys.root(root.from) + root.part * (keys.root(root.to) - keys.root(root.from));
      straight.emplace_back(place.x(), place.z());
      if (rooted[static_cast<size_t>(t)] != 0) root_keys.push_back(t);
    }
    yaws = yaws_along(straight, detours, root_keys);
  }
  for (int64_t t = 0; t < frames; ++t) {
    const size_t first = Poses::at(t, 0), frame = static_cast<size_t>(t);
    const Around pose = around(out.pose_distance[frame], t), root = around(out.root_distance[frame], t);
    for (int64_t j = 0; j < kStandardJoints; ++j) {
      Quaternionf q = local_rotation(keys, pose.from, j);
      if (pose.part > 0) q = q.slerp(pose.part, local_rotation(keys, pose.to, j));
      if (j == 0 && yaws[frame] != 0) q = Eigen::AngleAxisf(static_cast<float>(yaws[frame]), Vector3f::UnitY()) * q;
      const size_t parent = first + static_cast<size_t>(std::max(0, standard_parents()[static_cast<size_t>(j)]));
      out.poses.rotations[first + static_cast<size_t>(j)] = j == 0 ? q : (out.poses.rotations[parent] * q).normalized();
    }
    if (pose.part == 0 && pose.from == t)  // bit by bit
      std::copy_n(keys.rotations.begin() + static_cast<std::ptrdiff_t>(first), kStandardJoints,
                  out.poses.rotations.begin() + static_cast<std::ptrdiff_t>(first));
    Vector3f& at = out.poses.joints[first];
    at = keys.root(root.from) + root.part * (keys.root(root.to) - keys.root(root.from));
    if (detours.defined() && root.part > 0) at += Vector3f(detours[t][0].item<float>(), 0, detours[t][1].item<float>());
    place_joints(out.poses, t);
    out.heading[frame] = heading_of(out.poses, t, t == 0 ? 0.0F : out.heading[frame - 1]);
  }
  if (detours.defined()) out.legs = detour_legs(out.poses, yaws, root_keys, detours);
  out.targets = torch::zeros({frames, kStandardJoints, 4});
  for (int64_t t = 0; t < frames; ++t)
    for (int64_t j = 0; j < kStandardJoints; ++j)
      if (whole[static_cast<size_t>(t)] == 0 && constrains[t][kJointGroups + j] > 0) put_target(out, keys, t, j);
  return out;
}

}  // namespace

float KeyDistance::bridge() const {
  if (before < 0 || after < 0) return static_cast<float>(std::max(before, after));
  return before == 0 || after == 0
             ? 0
             : static_cast<float>(before) * static_cast<float>(after) / static_cast<float>(before + after);
}

Baseline baseline_of(const Poses& keys, const torch::Tensor& groups, const torch::Tensor& detours,
                     const KeyNoise& noise) {
  if (noise.level == 0) return baseline_through(keys, groups, detours);
  const Baseline plain = baseline_through(keys, groups, {});
  std::vector<int64_t> whole;
  std::vector<char> exact;
  for (int64_t t = 0; t < keys.frames(); ++t) {
    if (plain.pose_distance[static_cast<size_t>(t)].bridge() > 0) continue;
    whole.push_back(t);
    exact.push_back(noise.exact[static_cast<size_t>(t)]);
  }
  const Poses smooth = smooth_poses(plain.poses, whole, exact, noise.level, noise.rate);
  Poses cleaned = keys;
  for (size_t k = 0; k < whole.size(); ++k)
    if (exact[k] == 0) copy_frame(smooth, whole[k], cleaned);
  Baseline out = baseline_through(cleaned, groups, detours);
  for (size_t k = 0; k < whole.size(); ++k)
    for (int64_t j = 0; j < kStandardJoints && exact[k] == 0; ++j) put_target(out, keys, whole[k], j);
  for (size_t t = 0; t < out.noise.size(); ++t)
    if (noise.exact[t] == 0) out.noise[t] = static_cast<float>(noise.level);
  return out;
}

}  // namespace inhabit::inbetween
