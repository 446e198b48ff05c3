#pragma once
#include <string>
#include <string_view>

#include "inhabit/io/mesh.h"
#include "inhabit/scene/scene.h"

namespace inhabit {

/// A PLY file as it stands, in the file's own axes and units: ascii or binary of either byte order. Polygons are cut
/// into fans of triangles; a file without faces has `faces` (0, 3). Vertex colours, where there are any, are averaged
/// into `color`; all other elements and properties are skipped.
/// Throws Error(subject, ...) when it is no PLY, ends early, names a vertex that is not there or holds a NaN.
/// @param axes set where the file is of write_ply, whose header says what its axes and units are
Mesh parse_ply(std::string_view bytes, const std::string& subject, MeshAxes* axes = nullptr);

/// A scene as binary PLY, metres and +Y up, as a comment of its header says: all its meshes as one, or its points where
/// it has no mesh. Throws Error(path, ...) for an empty scene or where the file cannot be written.
void write_ply(const std::string& path, const Scene& scene);

}  // namespace inhabit
