#pragma once
#include <torch/types.h>

#include <string>
#include <vector>

#include "inhabit/metrics/motion_words.h"

namespace inhabit {

// The scores of anybody's motion: what `inhabit score` prints. Poses know neither place nor heading
// (motion/local_pose.h) but where said; futures of several lengths count as long as the shortest.

/// One motion and what errors call it.
struct NamedMotion {
  std::string name;      ///< its file
  torch::Tensor joints;  ///< (T, 22, 3) metres, world, standard skeleton
};

/// What a motion word is, and which of them count.
struct NdmsOptions {
  double rate = 25;                  ///< frames a second of the motions that are scored
  int64_t kappa = 8;                 ///< frames of a motion word
  int64_t observed = 0;              ///< frames at the start of each motion that were observed: words of them alone do
                                     ///< not count
  int64_t reference_stride = 2;      ///< the reference has so many times the rate (metrics/motion_words.h)
  WordKind words = WordKind::poses;  ///< poses frame by frame, of which joints, or words moved as the package does
};

/// NDMS of one motion.
struct NdmsOfMotion {
  std::string name;               ///< as given
  double ndms = 0;                ///< mean over its words, 0 to 1
  double coded = 0;               ///< the same in the form of the authors' code (NdmsForm::coded)
  int64_t words = 0;              ///< that count
  std::vector<double> by_second;  ///< of `ndms`
};

/// NDMS of several motions.
struct NdmsScore {
  double ndms = 0;                    ///< mean over all words
  double coded = 0;                   ///< in the form of the authors' code (NdmsForm::coded)
  int64_t words = 0;                  ///< of all motions
  int64_t reference_words = 0;        ///< that they were compared with, mirror images too
  std::vector<NdmsOfMotion> motions;  ///< each by itself, in the order given
};

/// NDMS (Eq. 10-12 of the anticipation paper) of motions against those of `reference`. Throws Error naming the motion
/// of which no word is left.
NdmsScore score_ndms(const std::vector<NamedMotion>& motions, const std::vector<NamedMotion>& reference,
                     const NdmsOptions& options);

/// NPSS of motions, each with what came true, as one batch (metrics/npss.h). Throws Error unless they are as many.
double score_npss(const std::vector<NamedMotion>& motions, const std::vector<NamedMotion>& truth);

/// Average pairwise distance of two futures or more by frame, (T) metres.
torch::Tensor score_apd(const std::vector<NamedMotion>& futures);
/// That of whole futures, as tables print it (metrics/diversity.h).
double score_sequence_apd(const std::vector<NamedMotion>& futures);

/// Errors by frame and over all frames, metres.
struct ErrorByFrame {
  torch::Tensor mean;       ///< (T) of each frame, over all futures
  torch::Tensor best;       ///< (T) of the future whose error is the least (metrics/forecast_error.h)
  double overall = 0;       ///< mean of `mean` over the frames
  double best_overall = 0;  ///< mean of `best` over the frames
};

/// How far futures are from what came true.
struct MotionError {
  ErrorByFrame pose;   ///< of the joints, poses without place and heading: whoever stands still as they walk has little
  ErrorByFrame path;   ///< of the root in the world
  ErrorByFrame world;  ///< of all joints in the world
};

/// Errors of futures against the one that came true. Throws Error where `truth` holds several.
MotionError score_error(const std::vector<NamedMotion>& futures, const std::vector<NamedMotion>& truth);

}  // namespace inhabit
