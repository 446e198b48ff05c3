#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "inhabit/scene/scene.h"

namespace inhabit {

/// Meshes of a .glb or .gltf file as its default scene places them: metres, +Y up, one for every node and primitive,
/// named after the node, else after the mesh; base colours, but no textures. Triangle lists, strips and fans;
/// points become a mesh with no faces; morph targets and animations are not applied. Meshes that have a skin are people
/// who stand in the scene: where there are others they are left out, else they are as they were modelled.
/// @param folder where files that it refers to lie; empty: such files are an error.
/// Throws Error(subject, ...) when it is damaged, its nodes form no tree, data lies outside its buffers, a vertex is
/// not finite, it is compressed (Draco, meshopt), or there are neither triangles nor points.
std::vector<Mesh> parse_gltf(std::string_view bytes, const std::string& subject, const std::string& folder);

}  // namespace inhabit
