#include "inhabit/io/joint_array.h"

#include <array>

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

bool rows_of_joints(const torch::Tensor& t) {
  return (t.dim() == 3 || t.dim() == 4) && t.size(-1) == 3 && t.size(-2) >= kLeast && t.size(-2) <= kMost;
}

/// The array of that name, whatever its case; empty where there is none that is `accepted`.
std::string named(const Npz& npz, const std::string& name, bool (*accepted)(const torch::Tensor&)) {
  for (const auto& [key, tensor] : npz.tensors)
    if (lower_case(key) == name && accepted(tensor)) return key;
  return "";
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

Npz with_joint_array(const Npz& npz) {
  const std::string name = joint_array_name(npz);
  if (name.empty()) return npz;
  Npz out = npz;
  torch::Tensor joints = out.tensors.at(name);
  if (flattened(joints)) joints = joints.view({joints.size(0), joints.size(1) / 3, 3});
  out.tensors.erase(name);
  out.tensors["joints"] = joints;
  return out;
}

}  // namespace inhabit
