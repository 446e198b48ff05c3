#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "inhabit/io/mesh.h"

namespace inhabit {

/// Meshes of an .fbx or .dae file in the file's units and axes, where its nodes place them, read by assimp in a child
/// process (in_child.h): triangles, names of the nodes, base colours; meshes that bones move only where there are no
/// others. @param axes set to what an .fbx says of them, may be null. Throws Error(subject, ...).
std::vector<Mesh> parse_node_meshes(std::string_view bytes, const std::string& extension, const std::string& subject,
                                    MeshAxes* axes = nullptr);

}  // namespace inhabit
