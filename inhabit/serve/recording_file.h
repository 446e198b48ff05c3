#pragma once
#include <string>
#include <vector>

#include "inhabit/serve/frames.h"
#include "inhabit/serve/world.h"

namespace inhabit::serve {

/// The bytes of a motion file of these frames. @param extension "bvh", "glb" (with the scene) or "npz".
std::string recording_file(const World& world, const std::vector<Frame>& frames, const std::string& extension);

}  // namespace inhabit::serve
