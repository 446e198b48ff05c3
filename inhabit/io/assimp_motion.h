#pragma once
#include <optional>
#include <string>
#include <vector>

#include "inhabit/io/source_motion.h"

namespace inhabit {

/// Motion of .fbx, .dae, .glb and .gltf files: the trees of bones and of animated nodes in them, read by assimp in a
/// child process (in_child.h). A tree under eight joints is no person. Nodes below a tree without a mesh (tips, fingers
/// that stand) are joints of it. Rest is the pose that the skin was bound in, or the nodes' own transform where there
/// is no skin: there all joints' axes are the world's, as in the other formats. Scales go into the places of joints.
///
/// The rate is that of the keys where they are dense (ten a second or more), or the file's own where that is higher; 30
/// where neither says anything. Lengths are metres in glTF, elsewhere what makes the bones those of a person
/// (guess_length_unit).
/// @param metres_per_unit empty: as said.
/// Nodes are told apart by their names: of people whose joints have the same ones the first is read.
/// @return each person's motion in each animation that moves them, the one of most joints (then of the longest motion)
/// first. Throws Error(path, ...): damaged, no skeleton that moves.
std::vector<SourceMotion> read_node_motions(const std::string& path, std::optional<double> metres_per_unit = {});

/// True where read_node_motions finds somebody. False for a scene; throws Error for a damaged file.
bool holds_node_motion(const std::string& path);

}  // namespace inhabit
