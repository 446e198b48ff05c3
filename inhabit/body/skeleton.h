#pragma once
#include <torch/types.h>

#include <array>
#include <string>
#include <vector>

namespace inhabit {

/// A tree of joints at rest. Parents come before their children; exactly one root, joint 0, has parent -1.
struct Skeleton {
  std::vector<std::string> names;  ///< as the file has them, or the standard ones
  std::vector<int> parents;        ///< indices; -1 for the root
  torch::Tensor offsets;  ///< (J, 3) metres, rest position relative to the parent; row 0 is the root's rest position.

  /// J, the number of joints.
  int size() const { return static_cast<int>(parents.size()); }
  /// Index of the joint called `name`, or -1.
  int find(const std::string& name) const;
  /// (J, 3) metres, rest positions in the root's frame (offsets summed down the tree).
  torch::Tensor rest_joints() const;
  /// Throws Error(subject, ...) unless sizes agree, parents form one tree in order and offsets are finite.
  void validate(const std::string& subject) const;
};

/// Number of joints of the standard skeleton.
inline constexpr int kStandardJoints = 22;

/// SMPL's first 22 joints, SMPL order: 0 pelvis, 1 left_hip, 2 right_hip, 3 spine1, 4 left_knee, 5 right_knee,
/// 6 spine2, 7 left_ankle, 8 right_ankle, 9 spine3, 10 left_foot, 11 right_foot, 12 neck, 13 left_collar,
/// 14 right_collar, 15 head, 16 left_shoulder, 17 right_shoulder, 18 left_elbow, 19 right_elbow, 20 left_wrist,
/// 21 right_wrist.
const std::vector<std::string>& standard_joint_names();
/// The parent of each standard joint, an index that is lower than the joint's; -1 for the pelvis.
const std::vector<int>& standard_parents();

/// Of the standard skeleton's joints those that stand on floors: left_ankle, right_ankle, left_foot, right_foot.
inline constexpr std::array<int64_t, 4> kFootJoints = {7, 8, 10, 11};
/// (..., 4, 3) kFootJoints of standard joints (..., 22, 3).
torch::Tensor foot_positions(const torch::Tensor& joints);

}  // namespace inhabit
