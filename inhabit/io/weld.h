#pragma once
#include <cstdint>
#include <vector>

#include "inhabit/scene/scene.h"

namespace inhabit {

/// A mesh of the vertices that `faces` name (x y z and three indices one after the other): those at the very same place
/// become one, those that no face names are left out. Files split vertices wherever normals or texture coordinates
/// differ.
Mesh weld(const std::vector<float>& vertices, const std::vector<int64_t>& faces);

}  // namespace inhabit
