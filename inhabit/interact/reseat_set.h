#pragma once
#include <map>
#include <string>
#include <vector>

#include "inhabit/data/native.h"
#include "inhabit/interact/reseat.h"
#include "inhabit/synth/generate.h"

namespace inhabit::interact {

/// What people are carried over to: chairs of files, drawn ones, or their own, rescaled.
enum class NewChairs { files, procedural, rescaled };

/// What is carried over to what.
struct ReseatOptions {
  NewChairs chairs = NewChairs::procedural;  ///< drawn as inhabit synth chairs draws them; rescaled: by up to an eighth
  std::vector<std::string> files;            ///< scene files of one chair each
  std::string split = "train";               ///< of which clips are carried over; "all" takes every clip
  bool frame_by_frame = false;               ///< ReseatChoices
  uint64_t seed = 1;                         ///< of which clip goes to which chair, and of drawn chairs
  Progress progress;                         ///< counts clips; may be empty
};

/// What was made, and why clips were left out.
struct ReseatResult {
  Dataset dataset;                        ///< what was written
  int64_t clips = 0;                      ///< that were looked at
  int64_t nobody_sits = 0;                ///< of them
  std::map<std::string, int64_t> no_fit;  ///< by what was wrong on the chair that came nearest
  int64_t contacts = 0;                   ///< of hands, in the clips that were made
  std::vector<ReseatFit> fits;            ///< of the clips that were made
  double skating_before = 0;              ///< fraction of their frames in which a foot slid on the old chairs
  double skating = 0;                     ///< fraction of their frames in which a foot slides
};

/// Augmentation: the clips of a native data set in which somebody sits on a chair, each carried over to another chair
/// (reseat.h), as a data set in `folder`. A clip that does not fit (ReseatFit::fault, or no place for what a hand
/// touches) is tried on up to seven other chairs and then left out. The bytes depend on the seed alone.
/// Throws Error for a file without a chair, and where no clip could be made.
ReseatResult reseat_dataset(const std::string& from, const std::string& folder, const ReseatOptions& options = {});

/// How many clips were made and how well they fit, and how many were left out and why: a line each.
std::string summary(const ReseatResult& result);

}  // namespace inhabit::interact
