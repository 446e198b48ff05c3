#pragma once
#include <string>
#include <vector>

#include "inhabit/io/read_options.h"
#include "inhabit/motion/clip.h"
#include "inhabit/progress.h"

namespace inhabit {

/// One recording of a labelled action, without a scene.
struct ActionMotion {
  std::string name;    ///< of the file, in notes and errors
  std::string action;  ///< "walking"
  std::string split;   ///< "train", "val" or "test"
  Clip clip;           ///< on the standard 22 joints
};

/// Reads the recordings of a data set at `rate` frames a second. `source` is one of
///   cmu:FOLDER   the exponential-map text of CMU's eight actions, FOLDER/train|test/ACTION/ACTION_N.txt. The last
///                training file of an action with three or more is "val"; an action without a test file gives the last
///                third of its last training file to "test";
///   h36m:FOLDER  Human3.6M's, FOLDER/S1/ACTION_N.txt: S5 is "test", the others "train", of S11 the last fifth "val";
///   FOLDER       a native data set, with its own splits; a clip's action is the one most of its frames have.
/// Of cmu: and h36m: files that are expected and missing, or damaged, are left out and named in `notes`. A clip of a
/// native data set that cannot be read is an error, as in every training: its index says what the set is.
/// @param progress counts files; may be empty. Throws Error(source, ...) where nothing is left.
std::vector<ActionMotion> read_motion_set(const std::string& source, double rate, Notes* notes = nullptr,
                                          const Progress& progress = {});

/// The recordings without those of "test", for choices that must not look at these: numbered within their action, those
/// whose number modulo `folds` is `fold` are "left_out", of the others the next one in turn is "val" where the action
/// has three or more, and the rest are "train". Over all folds each recording is left out once.
std::vector<ActionMotion> left_out_fold(const std::vector<ActionMotion>& motions, int64_t folds, int64_t fold);

/// Folds in which one recording of an action is left out at a time.
int64_t single_folds(const std::vector<ActionMotion>& motions);

}  // namespace inhabit
