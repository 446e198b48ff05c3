#pragma once
#include <torch/types.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace inhabit::anticipate {

// Intention labels (3.3): k-means over poses gives every frame a cluster; clusters that repeat in
// a cycle become one label, so that walking is one intention and not a fast alternation. docs/anticipation.md says how.

/// k-means with k-means++ seeding; the same seed gives the same centres.
/// @param points (N, D) float32, N >= k. @return centres (k, D), ordered by how many points they have.
torch::Tensor kmeans(const torch::Tensor& points, int64_t k, uint64_t seed, int64_t iterations = 50);

/// Nearest of `centres` (k, D) to each of `points` (N, D): (N) int64.
torch::Tensor nearest_centre(const torch::Tensor& points, const torch::Tensor& centres);

/// Frames [first, last) that are one run of a cluster (period 1) or a cycle: `period` runs repeated.
struct LabelSegment {
  int64_t first = 0;   ///< frame
  int64_t last = 0;    ///< one past the last frame
  int64_t period = 1;  ///< runs that are repeated

  bool operator==(const LabelSegment&) const = default;  ///< compares all three
};

/// What counts as a cycle of clusters.
struct CycleOptions {
  int64_t longest = 6;          ///< runs in a period
  int64_t repeats = 2;          ///< times a period must be seen whole
  int64_t longest_frames = 50;  ///< frames of a period
};

/// Cuts a sequence of cluster ids into cycles and single runs that follow each other without gaps. At each run the
/// period that repeats for the most frames wins, of equals the shortest; a cycle ends with the last run that fits it.
std::vector<LabelSegment> find_cycles(const std::vector<int64_t>& clusters, const CycleOptions& options = {});

/// What a segment of poses (T, D) is clustered by: their mean and twice their standard deviation, (2 D).
torch::Tensor describe_segment(const torch::Tensor& poses);

struct LabelAutoencoderImpl;

/// What is needed to label frames.
struct IntentionClusters {
  torch::Tensor poses;   ///< (K, D) centres of poses
  torch::Tensor labels;  ///< (C, 2 D) centres of segments (describe_segment); undefined for the naive labels, which
                         ///< are the pose clusters
  CycleOptions cycles;   ///< how segments were cut

  /// The authors' labels (released_labels.h) instead: centres (C, code) of what the encoder gives.
  torch::Tensor codes;
  std::shared_ptr<LabelAutoencoderImpl> encoder;  ///< where there are codes

  /// C, the number of labels.
  int64_t count() const { return (codes.defined() ? codes : labels.defined() ? labels : poses).size(0); }
};

/// @param sequences (T_i, D) poses. `labels` C intentions out of `clusters` pose clusters (ignored when naive).
IntentionClusters cluster_intentions(const std::vector<torch::Tensor>& sequences, int64_t labels, int64_t clusters,
                                     bool naive, uint64_t seed);

/// Label of every frame (T) int64 of a sequence of poses (T, D).
torch::Tensor intention_labels(const torch::Tensor& poses, const IntentionClusters& clusters);

}  // namespace inhabit::anticipate
