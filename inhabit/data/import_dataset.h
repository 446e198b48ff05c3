#pragma once
#include <string>
#include <vector>

#include "inhabit/data/import_set.h"
#include "inhabit/data/native.h"
#include "inhabit/progress.h"

namespace inhabit {

/// How an import runs.
struct ImportOptions {
  int jobs = 0;       ///< recordings at once; 0: as many as there are cores
  Shard shard;        ///< of scenes with all that was recorded in them
  Progress progress;  ///< counts recordings
};

/// What came of an import.
struct ImportResult {
  Dataset dataset;                   ///< as its index has it, or a shard's part of it
  int64_t made = 0;                  ///< clips that were written
  int64_t kept = 0;                  ///< clips that were there
  std::vector<std::string> skipped;  ///< recordings that could not be used, and why
};

/// Writes a native data set of the recordings: on the standard joints, 30 frames a second, the floor at y = 0. Contacts
/// and hand targets are labelled from the scene (metrics/touch_labels.h), actions are the set's own or told from the
/// motion. Recordings without a scene get a flat floor. The body's own parameters (`source_betas`, `pose_hand`, ...)
/// lie in the clips' files too. A scene that recordings of several splits share is there once for each. Clips that are
/// in `folder` already are kept, so that a run that was ended goes on; the index is written last. Throws Error where
/// nothing can be used, or where `folder` holds another data set.
ImportResult import_dataset(const ImportSet& set, const std::string& folder, const ImportOptions& options = {});

}  // namespace inhabit
