#pragma once
#include <array>
#include <string>
#include <vector>

#include "inhabit/body/skeleton.h"

namespace inhabit {

/// Which joints of any skeleton stand for the parts of a person. [0] is left, [1] right; -1 where there is none.
struct Landmarks {
  int pelvis = -1;              ///< the joint that legs and spine hang on
  int thorax = -1;              ///< the joint that arms and head hang on
  int neck = -1;                ///< first joint of the neck, a child of the thorax; -1 where the head follows at once
  int head = -1;                ///< base of the skull
  std::array<int, 2> hip;       ///< thigh's joint
  std::array<int, 2> knee;      ///< shin's joint
  std::array<int, 2> ankle;     ///< foot's joint
  std::array<int, 2> toe;       ///< ball of the foot; may be missing
  std::array<int, 2> collar;    ///< first joint from thorax to shoulder; may be missing
  std::array<int, 2> shoulder;  ///< upper arm's joint
  std::array<int, 2> elbow;     ///< forearm's joint
  std::array<int, 2> wrist;     ///< hand's joint
  std::vector<int> spine;       ///< joints from pelvis to thorax, both among them

  /// All are missing.
  Landmarks() {
    for (auto* part : {&hip, &knee, &ankle, &toe, &collar, &shoulder, &elbow, &wrist}) part->fill(-1);
  }
};

/// Finds them by the names of CMU and Vicon, Mixamo, Human3.6M, 3ds Max Biped, Unreal, Unity/VRM, Rigify, Daz, SMPL and
/// common BVH files ("LeftUpLeg", "mixamorig:LeftLeg", "lfemur", "Bip01 L Thigh", "thigh_l", "shin.L", "left_hip"...),
/// and by the tree where names differ most: the thorax is where arms and head part, the pelvis where legs and spine do.
/// Throws Error(subject, ...) naming the first part that no joint stands for.
Landmarks find_landmarks(const Skeleton& skeleton, const std::string& subject);

/// For each standard joint the joint that stands for it, -1 where there is none (spine1 and spine2, and what may be
/// missing).
std::array<int, kStandardJoints> counterparts(const Landmarks& marks);

/// The standard joint that a user means by a name: a standard one, or that of a joint of a file's skeleton which stands
/// for one. -1 where it is neither. @param file may be empty, or of a creature that has no landmarks
int standard_joint_called(const std::string& name, const Skeleton& file);

/// The names that standard_joint_called knows, for errors: "pelvis, left_hip, ...; of the file Hips, LeftUpLeg, ...".
std::string joint_names_for(const Skeleton& file);

}  // namespace inhabit
