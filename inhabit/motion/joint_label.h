#pragma once
#include <string>
#include <vector>

namespace inhabit {

/// What a joint's name says once case, separators, prefixes and side are taken off: "Bip01 L Thigh" -> left, "thigh".
struct JointLabel {
  int side = -1;     ///< 0 left, 1 right, -1 neither
  std::string part;  ///< lower case
};

/// Side and part that one joint's name says by itself.
JointLabel joint_label(const std::string& name);

/// The same of a skeleton's joints, without the words that four in five of them begin or end with, whatever these are:
/// "Skeleton 001_LThigh", "Robot_LeftUpLeg", "thigh_l_jnt".
std::vector<JointLabel> joint_labels(const std::vector<std::string>& names);

/// Names of each part of a limb, the more telling first. A name may stand for two parts ("shoulder" is the upper arm
/// where there is a "collar", and the collar where there is an "arm"); the order settles it.
namespace part_names {
extern const std::vector<std::string> kHip;       ///< of the joint that the thigh hangs on
extern const std::vector<std::string> kKnee;      ///< of the shin's joint
extern const std::vector<std::string> kAnkle;     ///< of the foot's joint
extern const std::vector<std::string> kToe;       ///< of the ball of the foot
extern const std::vector<std::string> kShoulder;  ///< of the upper arm's joint
extern const std::vector<std::string> kElbow;     ///< of the forearm's joint
extern const std::vector<std::string> kWrist;     ///< of the hand's joint
extern const std::vector<std::string> kHead;      ///< of the base of the skull
}  // namespace part_names

}  // namespace inhabit
