#pragma once
#include <string>
#include <string_view>

#include "inhabit/scene/scene.h"

namespace inhabit {

/// A PLY file as it stands, in the file's own axes and units: ascii or binary of either byte order. Polygons are cut
/// into fans of triangles; a file without faces has `faces` (0, 3). Vertex colours, where there are any, are averaged
/// into `color`; all other elements and properties are skipped.
/// Throws Error(subject, ...) when it is no PLY, ends early, names a vertex that is not there or holds a NaN.
Mesh parse_ply(std::string_view bytes, const std::string& subject);

}  // namespace inhabit
