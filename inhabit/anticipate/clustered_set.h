#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "inhabit/anticipate/intention_summary.h"
#include "inhabit/progress.h"
#include "inhabit/view/page.h"

namespace inhabit::anticipate {

/// The recordings of a data set with the intention labels that are clustered from those of "train".
struct ClusteredSet {
  std::string name;                  ///< of the data's folder
  std::vector<Sequence> recordings;  ///< those of "train", then of "val" and "test"
  Skeleton skeleton;                 ///< whose bones they are on
  double rate = 25;                  ///< frames a second
  IntentionSummary summary;          ///< of all recordings
};

/// @param data cmu:FOLDER, h36m:FOLDER or a native data set folder. @param config its rate and its labels' settings;
/// @param seed of the clusters. @param notes files that are left out are added to it. @param progress counts files; may
/// be empty. Throws what read_motion_set and training_skeleton throw.
ClusteredSet clustered_set(const std::string& data, const Config& config, uint64_t seed, Notes* notes = nullptr,
                           const Progress& progress = {});

/// The page of its labels and recordings (intention_page.h).
Page intention_page(const ClusteredSet& set);

}  // namespace inhabit::anticipate
