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
  /// Which recording shows the label: in it lies, of the quarter of the segments that are nearest to the label's
  /// centre, the longest.
  size_t recording = 0;
  int64_t first = 0;  ///< first frame of that segment
  int64_t last = 0;   ///< one past its last; `first` for a label without frames
};

/// Intention labels of a set of recordings.
struct IntentionSummary {
  std::vector<torch::Tensor> tracks;  ///< (T) int64 labels of every recording
  std::vector<LabelSummary> labels;   ///< a label each
};

/// @param rate frames a second of the recordings.
IntentionSummary summarise_intentions(const std::vector<Sequence>& recordings, const IntentionClusters& clusters,
                                      double rate);

/// The summary as text, a line a label: percent of the frames, segments, their mean seconds, the three actions it is
/// most seen in.
std::string summary_text(const IntentionSummary& summary);
/// The summary as JSON, an object a label: all its actions and, where it occurs, a representative segment (recording,
/// first and last frame).
/// @param recordings those that were summarised
nlohmann::json summary_json(const IntentionSummary& summary, const std::vector<Sequence>& recordings);

}  // namespace inhabit::anticipate
