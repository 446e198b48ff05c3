#pragma once
#include <functional>
#include <string>
#include <vector>

#include "inhabit/progress.h"

namespace inhabit {

/// What a pattern with * ? [ ] matches, in alphabetical order. Throws Error where that is nothing.
std::vector<std::string> files_matching(const std::string& pattern);

/// The motion files that a user names: a folder stands for those in it and below, by extension (of .npz and .npy those
/// that hold motion, and those that cannot be read), in alphabetical order; a pattern with * ? [ ] for what it matches,
/// unless a file is called so; anything else for itself. Throws Error for a folder or pattern with no such file.
std::vector<std::string> motion_files(const std::vector<std::string>& named);

/// The scenes in a folder and below that are no motion, in alphabetical order. Throws Error where there are none.
std::vector<std::string> scene_files(const std::string& folder);

/// Folders that a user names; a pattern with * ? [ ] stands for the folders that it matches, unless something is called
/// so. Throws Error for one that matches none.
std::vector<std::string> folders_matching(const std::vector<std::string>& named);

/// What became of many files.
struct FileCount {
  int64_t done = 0;                  ///< without an error
  std::vector<std::string> skipped;  ///< why, a line for each
};

/// Calls `work` for every file; one that throws Error is skipped. Throws the Error where it is the only file, or one
/// that says so where none worked. @param progress counts files; may be empty
FileCount each_file(const std::vector<std::string>& files, const std::function<void(const std::string& path)>& work,
                    const Progress& progress = {});

}  // namespace inhabit
