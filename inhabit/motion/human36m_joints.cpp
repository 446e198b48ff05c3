#include "inhabit/motion/human36m_joints.h"

#include <array>
#include <vector>

#include "inhabit/error.h"
#include "inhabit/motion/usual_skeleton.h"

namespace inhabit {
namespace {

struct Human36mJoint {
  int64_t row;  ///< of the 32
  const char* name;
  int parent;  ///< among these 17
};

// The 17 joints of the 32 that move, with the tree that they hang in.
constexpr std::array<Human36mJoint, 17> kHuman36mJoints = {{{0, "Hips", -1},
                                                            {1, "RightUpLeg", 0},
                                                            {2, "RightLeg", 1},
                                                            {3, "RightFoot", 2},
                                                            {6, "LeftUpLeg", 0},
                                                            {7, "LeftLeg", 4},
                                                            {8, "LeftFoot", 5},
                                                            {12, "Spine", 0},
                                                            {13, "Spine1", 7},
                                                            {14, "Neck", 8},
                                                            {15, "Head", 9},
                                                            {17, "LeftArm", 8},
                                                            {18, "LeftForeArm", 11},
                                                            {19, "LeftHand", 12},
                                                            {25, "RightArm", 8},
                                                            {26, "RightForeArm", 14},
                                                            {27, "RightHand", 15}}};

}  // namespace

bool in_human36m_order(const torch::Tensor& joints) {
  if (joints.dim() != 3 || joints.size(0) == 0 || (joints.size(1) != 17 && joints.size(1) != 32)) return false;
  const auto from_pelvis = [&](size_t joint) {
    const int64_t at = joints.size(1) == 32 ? kHuman36mJoints.at(joint).row : static_cast<int64_t>(joint);
    return (joints.select(1, at) - joints.select(1, 0)).norm(2, {1}).mean().item<double>();
  };
  constexpr size_t kRightHip = 1, kLeftHip = 4, kHead = 10;
  const double right = from_pelvis(kRightHip), left = from_pelvis(kLeftHip), head = from_pelvis(kHead);
  return right > 0.08 * head && right < 0.4 * head && left > 0.6 * right && left < 1.7 * right;
}

Clip human36m_clip(const torch::Tensor& joints, double rate, const std::string& subject) {
  if (joints.dim() != 3 || joints.size(2) != 3 || (joints.size(1) != 32 && joints.size(1) != 17) || joints.size(0) == 0)
    throw Error(subject, "is not (T, 32, 3) or (T, 17, 3)");
  std::vector<int64_t> rows;
  std::vector<std::string> names;
  std::vector<int> parents;
  for (const Human36mJoint& joint : kHuman36mJoints) {
    rows.push_back(joints.size(1) == 32 ? joint.row : static_cast<int64_t>(rows.size()));
    names.emplace_back(joint.name);
    parents.push_back(joint.parent);
  }
  const UsualSkeleton usual = usual_skeleton(names, parents, subject);
  Clip clip;
  clip.skeleton = usual.skeleton;
  clip.rate = rate;
  const std::vector<int64_t> order(usual.order.begin(), usual.order.end());
  clip.joints = joints.to(torch::kFloat32)
                    .index_select(1, torch::tensor(rows))
                    .index_select(1, torch::tensor(order))
                    .contiguous();
  validate(clip, subject);
  return clip;
}

}  // namespace inhabit
