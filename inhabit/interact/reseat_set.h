#pragma once
#include <string>
#include <vector>

#include "inhabit/data/native.h"
#include "inhabit/synth/generate.h"

namespace inhabit::interact {

struct ReseatOptions {
  std::vector<std::string> chairs;  ///< scene files of one chair each; empty: drawn as inhabit synth chairs draws them
  std::string split = "train";      ///< of which clips are carried over; "all" takes every clip
  uint64_t seed = 1;                ///< of which clip goes to which chair, and of drawn chairs
  Progress progress;
};

/// What was made, and why clips were left out.
struct ReseatResult {
  Dataset dataset;
  int64_t nobody_sits = 0, no_fit = 0;  ///< clips
  int64_t contacts = 0;                 ///< of hands, in the clips that were made
};

/// Augmentation: the clips of a native data set in which somebody sits on a chair, each carried over to another chair
/// (reseat.h), as a data set in `folder`. A clip that does not fit (no place for what a hand touches,
/// contacts more than 1 cm off, 2 cm deep in the chair, feet moved) is tried on up to seven other chairs and then left
/// out. The bytes depend on the seed alone.
/// Throws Error for a file without a chair, and where no clip could be made.
ReseatResult reseat_dataset(const std::string& from, const std::string& folder, const ReseatOptions& options = {});

}  // namespace inhabit::interact
