#include "inhabit/io/joint_array.h"

#include <array>

#include "inhabit/body/skeleton.h"
#include "inhabit/lower_case.h"

namespace inhabit {
namespace {

constexpr std::array kNames = {"keypoints",
                               "positions",
                               "poses_3d",
                               "joint_positions",
                               "joints_3d",
                               "joints3d",
                               "pose_3d",
                               "keypoints_3d",
                               "keypoints3d",
                               "poses3d",
                               "kpts",
                               "kpts_3d",
                               "arr_0",
                               "joints_pos",
                               "joint_position",
                               "pose3d",
                               "kp3d",
                               "joint_pos",
                               "joints_position",
                               "positions_3d",
                               "joint_coords",
                               "jointpositions",
                               "global_positions",
                               "pred_joints",
                               "new_joints"};
// Of these, rows of numbers may be anything: features, rotations.
constexpr std::array kVagueNames = {"xyz", "motion", "motions", "pred", "preds", "prediction", "predictions", "output"};
constexpr int64_t kLeast = 5, kMost = 256;  // joints of a person's skeleton

bool flattened(const torch::Tensor& t) {
  return t.dim() == 2 && t.size(1) % 3 == 0 && t.size(1) / 3 >= kLeast && t.size(1) / 3 <= kMost;
}

torch::Tensor unflattened(const torch::Tensor& t) { return flattened(t) ? t.view({t.size(0), t.size(1) / 3, 3}) : t; }

bool rows_of_joints(const torch::Tensor& t) {
  return (t.dim() == 3 || t.dim() == 4) && t.size(-1) == 3 && t.size(-2) >= kLeast && t.size(-2) <= kMost;
}

/// The array of that name, whatever its case; empty where there is none that is `accepted`.
std::string named(const Npz& npz, const std::string& name, bool (*accepted)(const torch::Tensor&)) {
  for (const auto& [key, tensor] : npz.tensors)
    if (lower_case(key) == name && accepted(tensor)) return key;
  return "";
}

/// Whether the first 22 of the rows (T, J, 3) move as SMPL's joints do: every bone has a length that stays within a
/// tenth of its mean, no limb's upper bone is twice as long as its lower one, or half, and some joint moves around the
/// root (rotations that stand still keep "lengths" as well).
bool keeps_bones(const torch::Tensor& rows) {
  const torch::Tensor around = rows.narrow(1, 0, kStandardJoints) - rows.narrow(1, 0, 1);
  if (!((around - around.mean(0, true)).norm(2, {2}).max() > 0.2 * around.norm(2, {2}).mean()).item<bool>())
    return false;
  std::vector<double> lengths(kStandardJoints, 0);
  for (int64_t j = 1; j < kStandardJoints; ++j) {
    const int64_t parent = standard_parents()[static_cast<size_t>(j)];
    const torch::Tensor length = (rows.select(1, j) - rows.select(1, parent)).norm(2, {1});
    const auto mean = length.mean().item<double>();
    lengths[static_cast<size_t>(j)] = mean;
    if (!(mean > 0) || (length - mean).abs().mean().item<double>() > 0.1 * mean) return false;
  }
  for (const auto& [upper, lower] : {std::pair(4, 7), std::pair(5, 8), std::pair(18, 20), std::pair(19, 21)}) {
    const double ratio = lengths[static_cast<size_t>(upper)] / lengths[static_cast<size_t>(lower)];
    if (ratio < 0.5 || ratio > 2) return false;
  }
  return true;
}

}  // namespace

std::string joint_array_name(const Npz& npz) {
  if (npz.has("joints")) return "joints";
  const auto any = [](const torch::Tensor& t) { return rows_of_joints(t) || flattened(t); };
  std::string found = named(npz, "joints", any);
  for (const char* name : kNames)
    if (found.empty()) found = named(npz, name, any);
  for (const char* name : kVagueNames)
    if (found.empty()) found = named(npz, name, rows_of_joints);
  return found;
}

std::string positions_called_poses(const Npz& npz) {
  for (const char* of_a_body : {"betas", "shape", "trans", "transl", "translation", "root_orient", "global_orient"})
    if (npz.has(of_a_body)) return "";
  for (const char* name : {"poses", "pose"}) {
    const auto found = npz.tensors.find(name);
    if (found == npz.tensors.end()) continue;
    const torch::Tensor joints = unflattened(found->second);
    if (joints.dim() == 3 && rows_of_joints(joints) && joints.size(0) > 0 && joints.size(1) >= kStandardJoints &&
        keeps_bones(joints.to(torch::kFloat32)))
      return name;
  }
  return "";
}

Npz with_joint_array(const Npz& npz) {
  std::string name = positions_called_poses(npz);
  if (name.empty()) name = joint_array_name(npz);
  if (name.empty()) return npz;
  Npz out = npz;
  const torch::Tensor joints = unflattened(out.tensors.at(name));
  out.tensors.erase(name);
  out.tensors["joints"] = joints;
  return out;
}

}  // namespace inhabit
