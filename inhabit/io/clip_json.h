#pragma once
#include <string>
#include <string_view>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// A clip as JSON that explains itself: "format" ("inhabit clip"), "version", "units" (what each array is measured in),
/// "rate", "frames", "skeleton" (a list of name, parent and offset), then `joints` (T, J, 3), `rotations` (T, J, 3),
/// `trans` (T, 3), `betas`, `gender`, `action_names`, `action`, `contact`, `hand_targets`, `object_names`,
/// `object_pose` as nested arrays, each only where it is known. Numbers keep every bit of a float.
std::string clip_json(const Clip& clip, const std::string& subject);
/// Writes the text of clip_json, whole or not at all. Throws Error(path, ...) for a clip that is not valid and where
/// the file cannot be written.
void write_clip_json(const std::string& path, const Clip& clip);

/// Reads it again; every array may be missing but `joints`, which forward kinematics gives where `rotations` and
/// `trans` are there. Throws Error(path, ...) for anything else than such a file.
Clip read_clip_json(const std::string& path);
/// As read_clip_json, from a file's text.
/// @param subject named in errors
Clip parse_clip_json(std::string_view text, const std::string& subject);

}  // namespace inhabit
