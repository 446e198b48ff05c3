#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "inhabit/scene/scene.h"

namespace inhabit {

/// Meshes of a Wavefront OBJ file in its own axes and units, one for every name (`o`, else `g`) and material. Polygons
/// are cut into fans of triangles; lines, points, curves and texture coordinates are skipped.
/// @param open gives the text of a file named by `mtllib`, or nothing where it cannot be had; diffuse colours come from
/// there. Throws Error(subject, ...) with the line for a vertex that is no three finite numbers or a face that names
/// one that is not there, and when there are no faces.
std::vector<Mesh> parse_obj(std::string_view text, const std::string& subject,
                            const std::function<std::string(const std::string&)>& open);

}  // namespace inhabit
