#include "inhabit/body/skeleton.h"

#include <set>

#include "inhabit/error.h"

namespace inhabit {

int Skeleton::find(const std::string& name) const {
  for (size_t j = 0; j < names.size(); ++j)
    if (names[j] == name) return static_cast<int>(j);
  return -1;
}

torch::Tensor Skeleton::rest_joints() const {
  std::vector<torch::Tensor> rest(parents.size());
  for (size_t j = 0; j < parents.size(); ++j)
    rest[j] = parents[j] < 0 ? offsets[j] : rest[parents[j]] + offsets[static_cast<int64_t>(j)];
  return torch::stack(rest);
}

void Skeleton::validate(const std::string& subject) const {
  if (parents.empty()) throw Error(subject, "the skeleton has no joints");
  if (names.size() != parents.size()) throw Error(subject, "the skeleton's names and parents differ in number");
  if (!offsets.defined() || offsets.dim() != 2 || offsets.size(0) != size() || offsets.size(1) != 3)
    throw Error(subject, "the skeleton's offsets are not (J, 3)");
  if (!torch::isfinite(offsets).all().item<bool>())
    throw Error(subject, "the skeleton has an offset that is not finite");
  if (const std::set<std::string> different(names.begin(), names.end()); different.size() != names.size())
    throw Error(subject, "two joints of the skeleton have one name");
  for (int j = 0; j < size(); ++j) {
    if ((j == 0) != (parents[j] == -1)) throw Error(subject, "joint 0 and no other must be the root");
    if (parents[j] >= j)
      throw Error(subject, "joint " + std::to_string(j) + " comes before its parent (or the tree has a cycle)");
  }
}

const std::vector<std::string>& standard_joint_names() {
  static const std::vector<std::string> names = {
      "pelvis",     "left_hip",    "right_hip",    "spine1",     "left_knee",     "right_knee",
      "spine2",     "left_ankle",  "right_ankle",  "spine3",     "left_foot",     "right_foot",
      "neck",       "left_collar", "right_collar", "head",       "left_shoulder", "right_shoulder",
      "left_elbow", "right_elbow", "left_wrist",   "right_wrist"};
  return names;
}

const std::vector<int>& standard_parents() {
  static const std::vector<int> parents = {-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19};
  return parents;
}

torch::Tensor foot_positions(const torch::Tensor& joints) {
  return joints.index_select(-2, torch::tensor(at::IntArrayRef(kFootJoints), joints.device()));
}

}  // namespace inhabit
