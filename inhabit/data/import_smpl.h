#pragma once
#include <functional>
#include <string>
#include <vector>

#include "inhabit/data/import_set.h"
#include "inhabit/io/npz.h"

namespace inhabit {

/// A motion from arrays of the SMPL family (clip_npz.h), and what of its parameters a 22-joint clip has no place for:
/// `pose_hand`, `pose_jaw`, `pose_eye` (T, 90 | 3 | 6) radians, also out of a whole `poses`, and `expression`.
/// @param z_up the world that the arrays are in; it is not looked for, so that somebody may lie in it
ImportedMotion smpl_motion(const Npz& npz, const std::string& subject, const ClipReadOptions& reading, bool z_up);

/// Files in a folder and below it that `wanted` takes, in alphabetical order. Throws Error(folder, ...) where it cannot
/// be read.
std::vector<std::string> files_below(const std::string& folder, const std::function<bool(const std::string&)>& wanted);

/// The path from `folder` to a file, with forward slashes and without its extension.
std::string name_below(const std::string& folder, const std::string& path);

}  // namespace inhabit
