#pragma once
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <tuple>
#include <vector>

#include "inhabit/anticipate/intention.h"
#include "inhabit/nn/feature_scale.h"

namespace inhabit::anticipate {

/// What futures follow, frame by frame: S of T frames.
struct Followed {
  torch::Tensor features;  ///< (S, T, F) metres and radians: the remembered frame
  torch::Tensor changes;   ///< (S, T, F) to it from the frame before it in its recording
  torch::Tensor labels;    ///< (S, T) int64 intentions

  /// From `frame` on.
  Followed from(int64_t frame) const {
    if (!features.defined()) return {};
    return {features.slice(1, frame), changes.slice(1, frame), labels.slice(1, frame)};
  }
  /// As networks see it.
  Followed to_network(const FeatureScale& scale) const {
    return {scale.to_network(features), changes / scale.deviation, labels};
  }
  /// On another device.
  Followed on(torch::Device d) const {
    if (!features.defined()) return {};
    return {features.to(d), changes.to(d), labels.to(d)};
  }
};

/// Features are remembered as whole multiples of this, 0.06 mm (and radians as many), up to 2 m from the root.
inline constexpr double kMemoryUnit = 0x1.0p-14;

/// A recording that is remembered.
struct Remembered {
  torch::Tensor features;   ///< (T, F) metres and radians, multiples of kMemoryUnit
  torch::Tensor typical;    ///< (T) how typical the motion is that goes on from each frame (typical_motion)
  bool validation = false;  ///< of the validation split: not looked at while weights and settings are chosen
};

/// Recorded motion that futures go on from (not in the paper). Where a future begins, where the recording that it
/// follows ends, and at times before, it goes on in one whose motion word is like the last one. Of each recording (and
/// each mirror image) the best place is a candidate; one is drawn with a probability proportional to
///   exp(-d / distance + weight * typical) p(label),
/// d (metres) being the root mean square distance of the words' joints, p the intention network's of the label that the
/// candidate goes on with. It is followed somewhat slower or faster than it was recorded. In the first second the mean
/// of the nearest continuations of all recordings fades into the one that was drawn: of what comes next they know more
/// together than one does.
class MotionMemory {
 public:
  /// How places are chosen.
  struct Choice {
    int64_t kappa = 8;       ///< frames of a motion word
    double distance = 0.01;  ///< metres; over 0
    double typical = 0;      ///< weight
    double within = 1;       ///< metres: places that are so much farther away than the nearest are no candidates
    double stay = 0;  ///< after two seconds another recording is chosen every so many frames in the mean; 0: never
    double warp = 0;  ///< speeds are within 1 - warp and 1 + warp; under 1
  };

  /// @param recordings without their mirror images; `typical` is that of the mirror image as well. @param subject
  /// named where they are too short.
  MotionMemory(std::vector<Remembered> recordings, const IntentionClusters& clusters, const Choice& by,
               const std::string& subject);

  /// What was given to the constructor.
  const std::vector<Remembered>& recordings() const { return recordings_; }

  /// Log-probabilities (S, C) of each future's next label.
  using LabelScores = std::function<torch::Tensor()>;
  /// Is told the labels (S) int64 of a frame.
  using LabelsSeen = std::function<void(const torch::Tensor&)>;

  /// Draws what S futures follow. @param past (S, t, F) metres and radians, or one for all (1, t, F), at least kappa
  /// frames; @param choice (S, T, 3) uniform numbers in [0, 1), three for each frame; @param without recordings that
  /// are not followed, one of each future (-1: all are), or empty; @param scores, seen the intention network, or empty.
  Followed follow(const torch::Tensor& past, const torch::Tensor& choice, const std::vector<int64_t>& without = {},
                  const LabelScores& scores = {}, const LabelsSeen& seen = {}) const;

 private:
  struct Candidate {
    int64_t motion = 0, frame = 0;  // of motions_; the first frame to follow
    double score = 0;               // logarithm, without the label's part
    int64_t nearest = 0;            // the same of the nearest place of the motion,
    double distance = 0;            // and how far its word is
  };
  std::vector<Candidate> candidates(const torch::Tensor& seen, const std::vector<int64_t>& without) const;
  const std::vector<Candidate>& leaving(int64_t motion, int64_t frame, int64_t without) const;
  Followed nearest_mean(std::vector<Candidate> among) const;
  const Candidate& drawn(const std::vector<Candidate>& among, double uniform, const float* label_scores) const;
  struct Position {
    int64_t motion = 0;           // of motions_
    double frame = 0, speed = 1;  // in it, and frames a frame
    int64_t since = 0;            // the future's frame in which it was chosen
  };
  void copy(const Position& at, float* features, float* changes) const;

  Choice by_;
  std::vector<Remembered> recordings_;
  struct Motion {
    torch::Tensor features, labels;  // (T, F), (T)
    int64_t first_word, words;       // rows of words_; word i ends before frame kappa + i stride
  };
  std::vector<Motion> motions_;              // 2 i: recording i, 2 i + 1: its mirror image
  int64_t stride_ = 1;                       // frames from place to place
  torch::Tensor words_, squared_, typical_;  // (W, D), (W), (W)
  mutable std::mutex leaving_mutex_;
  /// By motion, frame and the recording that is not followed, as they are asked for.
  mutable std::map<std::tuple<int64_t, int64_t, int64_t>, std::vector<Candidate>> leaving_;
};

/// How typical the motion of each recording is among those of its action: mean NDMS (Eq. 12) of the words of the next
/// two seconds beside all other recordings of the action, less the action's own mean; 0 where it has no other.
/// @param features (T_i, F) of recordings, @param actions of each. @return (T_i) of the motion after each frame.
std::vector<torch::Tensor> typical_motion(const std::vector<torch::Tensor>& features,
                                          const std::vector<std::string>& actions, int64_t kappa);

}  // namespace inhabit::anticipate
