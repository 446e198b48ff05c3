#pragma once
#include <memory>
#include <string>
#include <vector>

#include "inhabit/anticipate/model_file.h"
#include "inhabit/motion/clip.h"

namespace inhabit {

struct AnticipateOptions {
  int64_t start = -1;    ///< first frame to forecast, counted in the clip; -1: its end
  int64_t samples = 10;  ///< futures
  double seconds = 4;    ///< how far
  uint64_t seed = 1;     ///< a future depends on it and its own number alone
  bool solve = false;    ///< rotations by fit_body(), a second each, instead of fit_rotations()
};

/// Futures of one observation, in its world, at the model's rate.
struct Anticipation {
  Clip past;                  ///< what was observed, on the person's own bones
  std::vector<Clip> futures;  ///< (S) of T frames each, joint rotations on the same bones
  torch::Tensor labels;       ///< (S, T) int64 intentions; undefined for a model without them
};

/// Intention-driven anticipation: a motion in, many plausible futures of up to any length out. On the CPU.
///
///   IntentionAnticipator anticipator = IntentionAnticipator::load("anticipate-cmu.safetensors");
///   Anticipation a = anticipator.anticipate(clip, {.samples = 50, .seconds = 30}, "walk.bvh");
class IntentionAnticipator {
 public:
  static IntentionAnticipator load(const std::string& path);
  explicit IntentionAnticipator(const AnticipateNetworks& networks);
  ~IntentionAnticipator();
  IntentionAnticipator(IntentionAnticipator&&) noexcept;

  const AnticipateConfig& config() const;

  /// Observes up to config().observed frames before the start, and at least kappa of them, of a clip on any skeleton
  /// that maps to the standard one, at any rate. @param subject names the clip in errors.
  Anticipation anticipate(const Clip& clip, const AnticipateOptions& options, const std::string& subject) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace inhabit
