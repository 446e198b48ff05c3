#pragma once
#include <string>
#include <string_view>

#include "inhabit/scene/scene.h"

namespace inhabit {

/// An STL file, ascii or binary, in its own axes and units; corners at the very same place become one vertex.
/// Throws Error(subject, ...) when it ends early, holds a coordinate that is not finite, or no triangle.
Mesh parse_stl(std::string_view bytes, const std::string& subject);

/// An OFF file (also COFF, NOFF: colours and normals are skipped), polygons cut into fans of triangles.
/// Throws Error(subject, ...) when it ends early, a vertex is not three finite numbers, a face names a vertex that is
/// not there, or there are no faces.
Mesh parse_off(std::string_view text, const std::string& subject);

}  // namespace inhabit
