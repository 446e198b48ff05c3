#pragma once
#include <string>

#include "inhabit/scene/scene.h"

namespace inhabit {

/// The cloud of frames [first, last) of a GTA-IM recording as the release makes it: every tenth frame's depth up to 10
/// m without the person (and a pixel around them), one point for each centimetre's voxel of a frame and for two
/// centimetres' of all. Metres, +Y up. Throws Error(file, ...) where a file is damaged, or no frame has an image.
Scene gta_im_scene(const std::string& recording, int64_t first, int64_t last);

}  // namespace inhabit
