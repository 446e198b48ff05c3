#pragma once
#include <string>
#include <vector>

namespace inhabit {

/// The joints of one person of a file and where an animation has them, in the file's units and axes.
struct NodeTracks {
  std::vector<std::string> names;  ///< of the joints (J), as the file has them
  std::vector<int> parents;        ///< -1 for the first, which is the root; parents come before children
  std::vector<double> rest;        ///< (J, 4) global rotation at rest, quaternion x y z w
  std::vector<double> joints;      ///< (T, J, 3) global places
  std::vector<double> rotations;   ///< (T, J, 4) global rotations
  double rate = 30;                ///< frames a second
  std::string animation;           ///< its name
  int64_t alike = 0;               ///< people left out: assimp tells nodes by their names, and theirs are these
};

/// The people of a file as assimp reads it, in this process: an assertion of assimp ends it (in_child.h). One after the
/// other, those with most joints first, each with the animations that move it, the longest first.
/// @param sampled false: joints and rotations are left empty. Throws Error(path, ...).
std::vector<NodeTracks> node_tracks(const std::string& path, bool sampled);

}  // namespace inhabit
