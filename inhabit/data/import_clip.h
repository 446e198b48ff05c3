#pragma once
#include <optional>
#include <string>

#include "inhabit/data/import_set.h"
#include "inhabit/data/native.h"

namespace inhabit {

/// Letters that stay in names of files; a folder of the source becomes two underscores.
std::string import_file_name(const std::string& name);

/// A clip that an earlier run wrote, its frames filled in; nothing where there is none, or it cannot be used.
std::optional<DatasetClip> imported_clip(const Dataset& dataset, DatasetClip entry);

/// The recording on the standard joints at 30 frames a second, its own parameters along. Throws Error.
ImportedMotion prepared_motion(const ImportSet& set, const ImportRecording& recording);

}  // namespace inhabit
