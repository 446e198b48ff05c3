#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "inhabit/io/read_options.h"

namespace inhabit {

/// What a file is and holds, for `inhabit info`: an object with "kind" ("motion", "scene", "weights", "body model",
/// "data set", "arrays") and what matters of that kind; lengths in metres, times in seconds.
/// @param path a motion, a scene, a .safetensors file, an SMPL-family model (.npz), or a data set (its folder or
/// dataset.json). Throws Error(path, ...) for anything that cannot be read.
nlohmann::ordered_json describe_file(const std::string& path, const ClipReadOptions& options = {});

}  // namespace inhabit
