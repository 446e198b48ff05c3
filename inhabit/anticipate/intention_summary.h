#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "inhabit/anticipate/sample.h"

namespace inhabit::anticipate {

/// One intention label over a set of recordings. A segment is a longest stretch of frames with one label.
struct LabelSummary {
  double fraction = 0;                                  ///< of all frames
  int64_t segments = 0;                                 ///< how many there are
  double seconds = 0;                                   ///< their mean length
  std::vector<std::pair<std::string, double>> actions;  ///< fractions of the label's frames, largest first
  /// Frames [first, last) of recordings[recording] that show the label: of the quarter of its segments that are nearest
  /// to its centre, the longest. Empty (first = last) for a label without frames.
  size_t recording = 0;
  int64_t first = 0, last = 0;
};

struct IntentionSummary {
  std::vector<torch::Tensor> tracks;  ///< (T) int64 labels of every recording
  std::vector<LabelSummary> labels;
};

/// @param rate frames a second of the recordings.
IntentionSummary summarise_intentions(const std::vector<Sequence>& recordings, const IntentionClusters& clusters,
                                      double rate);

std::string summary_text(const IntentionSummary& summary);
nlohmann::json summary_json(const IntentionSummary& summary, const std::vector<Sequence>& recordings);

}  // namespace inhabit::anticipate
