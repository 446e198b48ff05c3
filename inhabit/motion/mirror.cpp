#include "inhabit/motion/mirror.h"

#include <algorithm>

namespace inhabit {
namespace {

torch::Tensor find_other_sides() {
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

/// Axis-angle (..., 3) of the mirrored rotation.
torch::Tensor mirrored_rotations(const torch::Tensor& rotations) {
  torch::Tensor out = rotations.clone();
  out.slice(-1, 1, 3).neg_();
  return out;
}

}  // namespace

const torch::Tensor& other_sides() {
  static const torch::Tensor other = find_other_sides();
  return other;
}

torch::Tensor mirrored_points(const torch::Tensor& points) {
  torch::Tensor out = points.clone();
  out.select(-1, 0).neg_();
  return out;
}

torch::Tensor mirrored_joints(const torch::Tensor& joints) {
  return mirrored_points(joints.index_select(joints.dim() - 2, other_sides()));
}

Clip mirrored(const Clip& clip) {
  const torch::Tensor& other = other_sides();
  static const torch::Tensor hands = torch::tensor({int64_t{1}, int64_t{0}});
  Clip out = clip;
  out.skeleton.offsets = mirrored_points(clip.skeleton.offsets.index_select(0, other));
  out.joints = mirrored_joints(clip.joints);
  if (clip.rotations.defined()) out.rotations = mirrored_rotations(clip.rotations.index_select(1, other));
  if (clip.trans.defined()) out.trans = mirrored_points(clip.trans);
  if (clip.translations.defined()) out.translations = mirrored_points(clip.translations.index_select(1, other));
  if (clip.contact.defined()) out.contact = clip.contact.index_select(1, other);
  if (clip.hand_targets.defined()) out.hand_targets = mirrored_points(clip.hand_targets.index_select(1, hands));
  if (clip.object_pose.defined())
    out.object_pose = torch::cat(
        {mirrored_points(clip.object_pose.slice(2, 0, 3)), mirrored_rotations(clip.object_pose.slice(2, 3))}, 2);
  return out;
}

}  // namespace inhabit
