#include "inhabit/anticipate/clustered_set.h"

#include <filesystem>

#include "inhabit/anticipate/intention_page.h"

namespace inhabit::anticipate {

ClusteredSet clustered_set(const std::string& data, const Config& config, uint64_t seed, Notes* notes,
                           const Progress& progress) {
  ClusteredSet out;
  out.name = std::filesystem::path(data + "/").parent_path().filename().string();
  out.rate = config.rate;
  const auto motions = read_motion_set(data, config.rate, notes, progress);
  out.skeleton = training_skeleton(motions, data);
  out.recordings = sequences_of(motions, "train", out.skeleton, config.rate);
  const IntentionClusters clusters = cluster_recordings(out.recordings, config, seed);
  for (const char* split : {"val", "test"})
    for (Sequence& recording : sequences_of(motions, split, out.skeleton, config.rate))
      out.recordings.push_back(std::move(recording));
  out.summary = summarise_intentions(out.recordings, clusters, config.rate);
  return out;
}

Page intention_page(const ClusteredSet& set) {
  return intention_page(set.summary, set.recordings, set.skeleton, set.rate, "Intentions of " + set.name);
}

}  // namespace inhabit::anticipate
