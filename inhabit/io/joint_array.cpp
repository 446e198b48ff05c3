#include "inhabit/io/joint_array.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace inhabit {
namespace {

// In lower case; of several in one file the first counts.
constexpr std::array kNames = {"joints",         "keypoints", "positions", "poses_3d",     "joint_positions",
                               "joints_3d",      "joints3d",  "pose_3d",   "keypoints_3d", "keypoints3d",
                               "poses3d",        "kpts",      "kpts_3d",   "arr_0",        "joints_pos",
                               "joint_position", "xyz",       "motion",    "pred"};
constexpr int64_t kLeast = 5, kMost = 256;  // joints of a person's skeleton

bool flattened(const torch::Tensor& t) {
  return t.dim() == 2 && t.size(1) % 3 == 0 && t.size(1) / 3 >= kLeast && t.size(1) / 3 <= kMost;
}

bool is_joints(const torch::Tensor& t) {
  const bool rows = (t.dim() == 3 || t.dim() == 4) && t.size(-1) == 3 && t.size(-2) >= kLeast && t.size(-2) <= kMost;
  return rows || flattened(t);
}

std::string in_lower_case(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name;
}

}  // namespace

std::string joint_array_name(const Npz& npz) {
  if (npz.has("joints")) return "joints";
  for (const char* usual : kNames)
    for (const auto& [name, array] : npz.tensors)
      if (in_lower_case(name) == usual && is_joints(array)) return name;
  return "";
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
