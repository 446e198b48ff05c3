#pragma once
#include <functional>
#include <string>
#include <vector>

#include "inhabit/io/convert.h"
#include "inhabit/io/many_files.h"
#include "inhabit/progress.h"

namespace inhabit {

/// What motions and scenes become: "npz" and its like.
const std::vector<std::string>& convert_formats();

/// Converts files, folders of motion and patterns into the folder `out`, as conversions() has it, which is made where
/// there is none. Files that cannot be converted are skipped.
/// @param format one of convert_formats(). @param told called with each file that is written and its line
/// (convert_file); may be empty. @param notes what was detected is added to it, behind each file's name; may be null.
/// @param progress counts files; may be empty. Throws Error where `out` is named like a file, and where no file could
/// be converted.
FileCount convert_files(const std::vector<std::string>& named, const std::string& out, const std::string& format,
                        const ConvertOptions& options,
                        const std::function<void(const std::string& file, const std::string& line)>& told = {},
                        Notes* notes = nullptr, const Progress& progress = {});

}  // namespace inhabit
