#pragma once
#include <string>
#include <vector>

#include "inhabit/anticipate/model_file.h"
#include "inhabit/data/motion_set.h"

namespace inhabit::anticipate {

/// A recording as the networks see it, and as the score's database does.
struct Sequence {
  std::string name;           ///< its file
  std::string action;         ///< as it is labelled
  torch::Tensor features;     ///< (T, F) metres and radians, on the model's bones
  torch::Tensor joints = {};  ///< (T', 22, 3) world, at `stride` times the rate; undefined: those of the features
  int64_t stride = 1;         ///< frames of `joints` in one of `features`
  std::string split = {};     ///< "train", "val" or "test"; empty: of no data set
};

/// What people read of a recording: its name and, where it is not trained on, its split: "walking_3 (test)".
std::string shown_name(const Sequence& recording);

/// The recordings of one split on the bones of `skeleton`. Clips come at `rate` or a whole multiple of it: at
/// kDatabaseStride times the rate the score's database has the words that begin in every such frame.
std::vector<Sequence> sequences_of(const std::vector<ActionMotion>& motions, const std::string& split,
                                   const Skeleton& skeleton, double rate);
/// How many times the frames of a recording are denser than the model's where the score's database is made.
inline constexpr int64_t kDatabaseStride = 2;

/// The bones of the first training recording. Throws Error(source, ...) where there is none.
Skeleton training_skeleton(const std::vector<ActionMotion>& motions, const std::string& source);

/// The actions that there are, sorted.
std::vector<std::string> action_names(const std::vector<Sequence>& sequences);

/// Poses (..., 63) of features (..., F), which intentions are clustered from.
torch::Tensor intention_poses(const torch::Tensor& features);

/// Intention labels clustered from recordings and their mirror images, as `config` has it.
IntentionClusters cluster_recordings(const std::vector<Sequence>& recordings, const Config& config, uint64_t seed);

/// What the networks' memory is made of (motion_memory.h).
std::vector<Remembered> remembered_motion(const std::vector<Sequence>& recordings, int64_t kappa);

/// An observation (`observed`, F) of the frames before `now`, left-padded with the recording's first frame where it
/// begins later.
torch::Tensor observation(const torch::Tensor& features, int64_t now, int64_t observed);

/// Where sequences are cut into windows: `now` is the first future frame.
struct Cut {
  size_t sequence = 0;  ///< which of them
  int64_t now = 0;      ///< frame of its features
};

/// Windows for a test: up to `per_action` of every action, spread evenly over its recordings. Each is observed for
/// config.observed frames and has a second of future. Of shorter recordings all but the last 0.4 s are observed; those
/// that leave fewer than kappa frames are left out.
std::vector<Cut> test_windows(const std::vector<Sequence>& sequences, const Config& config, int64_t per_action);

/// Training data: every recording and its mirror image, with intention labels.
class Data {
 public:
  /// @param networks config, skeleton, scale and clusters are read.
  Data(std::vector<Sequence> sequences, const Networks& networks);

  /// Windows, each action's repeated (up to eight times) until it has as many as the largest.
  int64_t size() const { return static_cast<int64_t>(windows_.size()); }

  /// A window as the networks are trained on it.
  struct Sample {
    torch::Tensor frames;    ///< (observed + future, F) standardised; what lies beyond the recording repeats its end
    torch::Tensor labels;    ///< (observed + max(label_frames, future + gamma - 1)) int64
    int64_t first = 0;       ///< first frame of `frames` that was recorded
    int64_t last = 0;        ///< one past the last that was
    int64_t last_label = 0;  ///< one past the last label that was
    int64_t recording = 0;   ///< which of the sequences it is of
    int64_t action = 0;      ///< which of action_names()
  };
  /// Window `index`, or its mirror image.
  Sample sample(int64_t index, bool mirrored) const;

 private:
  Config config_;
  std::vector<torch::Tensor> features_, labels_;  // 2 i: sequence i, 2 i + 1: its mirror image
  std::vector<Cut> windows_;
  std::vector<int64_t> actions_;  // of each sequence
};

}  // namespace inhabit::anticipate
