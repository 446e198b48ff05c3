#pragma once
#include <string>
#include <vector>

#include "inhabit/body/skeleton.h"

namespace inhabit {

/// A tree over joints of which only names are known, and where each is among these.
struct UsualSkeleton {
  Skeleton skeleton;       ///< parents first; offsets are where joints lie in somebody who stands, zero where not known
  std::vector<int> order;  ///< joint j of the skeleton is joint order[j] of the names
};

/// The standard 22 joints in somebody who stands with hanging arms.
Skeleton standing_skeleton();

/// The tree of joints that trackers, cameras and tools report by name alone, without rotations: SMPL's, Human3.6M's,
/// Kinect's, OptiTrack's, Mixamo's and the like. Spine joints hang on each other by their numbers, else in the order of
/// the names, limbs where limbs do, eyes and ears on the head, fingers on the wrist; what is unknown hangs on the
/// pelvis.
/// @param parents of each name, -1 for the root; empty: guessed as above. Throws Error(subject, ...) where a name is
/// there twice, parents are no tree, or a part that retargeting needs is not among the names (find_landmarks).
UsualSkeleton usual_skeleton(const std::vector<std::string>& names, const std::vector<int>& parents,
                             const std::string& subject);

}  // namespace inhabit
