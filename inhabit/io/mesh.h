#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "inhabit/scene/scene.h"

namespace inhabit {

/// What a mesh file says of its own axes and units. Only .fbx does; glTF's are defined.
struct MeshAxes {
  char up = 0;        ///< 'y' or 'z'; 0: it does not say
  double metres = 0;  ///< of a unit; 0: it does not say
};

/// Meshes of an .obj, .ply, .glb, .gltf, .fbx, .dae, .off or .stl file in the file's own axes and units, each as its
/// format's reader says. A mesh without a name gets the file's, and a number where a name comes twice. Degenerate faces
/// stay (see drop_degenerate_faces); a .ply without faces, and points in glTF, give meshes with no faces. Throws
/// Error(path, ...) when the file is missing, damaged, holds a NaN or infinite coordinate, or nothing to draw.
std::vector<Mesh> read_meshes(const std::string& path, MeshAxes* axes = nullptr);

/// The same from memory; `extension` ("obj") tells the format, files it refers to (materials, buffers) are not read.
std::vector<Mesh> parse_meshes(std::string_view bytes, const std::string& extension, const std::string& subject,
                               MeshAxes* axes = nullptr);

/// Removes faces with a repeated vertex or with no area (under 1e-12 of the mesh's squared size); returns how many.
int64_t drop_degenerate_faces(Mesh& mesh);

}  // namespace inhabit
