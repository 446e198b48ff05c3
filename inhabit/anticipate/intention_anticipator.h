#pragma once
#include <memory>
#include <string>
#include <vector>

#include "inhabit/anticipate/model_file.h"
#include "inhabit/motion/clip.h"
#include "inhabit/progress.h"
#include "inhabit/scene/scene.h"

namespace inhabit::anticipate {

/// What futures are asked for.
struct Options {
  int64_t start = -1;           ///< first frame to forecast, counted in the clip; -1: its end
  int64_t samples = 10;         ///< futures, at most 100,000
  double seconds = 4;           ///< how far
  uint64_t seed = 1;            ///< a future depends on it and its own number alone
  std::string name = "motion";  ///< what errors call the clip
  bool standard = false;        ///< futures are wanted on the standard skeleton alone
  bool solve = false;           ///< rotations by fit_body(), a second each, instead of fit_rotations()
  bool refine = false;          ///< feet stand, nobody is inside the scene (refine/): a second for each half minute
  Progress progress = {};       ///< futures; may be empty
};

/// Futures of one observation, in its world, at the model's rate.
struct Result {
  Clip past;                  ///< what was observed, on the person's own bones
  std::vector<Clip> futures;  ///< (S) of T frames each, joint rotations on the same bones
  torch::Tensor labels;       ///< (S, T) int64 intentions; undefined for a model without them
  /// Futures and labels on the clip's own skeleton, at its rate (motion/transfer.h); empty where Options::standard is
  /// set.
  std::vector<Clip> on_source;
  torch::Tensor labels_on_source;  ///< (S, T') int64
  Scene scene;                     ///< as given
};

/// Intention-driven anticipation: a motion in, many plausible futures of up to any length out. On the CPU. Safe to use
/// from several threads.
///
///   const auto anticipator = anticipate::IntentionAnticipator::load("anticipate-cmu.safetensors");
///   anticipate::Result r = anticipator.run(clip, scene, {.samples = 50, .seconds = 30});   // r.futures
class IntentionAnticipator {
 public:
  /// Throws Error naming the file where it is no such model or lacks a network.
  static IntentionAnticipator load(const std::string& path);
  /// Throws Error where a network is missing.
  explicit IntentionAnticipator(const Networks& networks);
  ~IntentionAnticipator();
  IntentionAnticipator(IntentionAnticipator&&) noexcept;  ///< what was moved from may only be destroyed

  /// Rates, lengths and sizes that the networks were made with.
  const Config& config() const;

  /// Observes up to config().observed frames before the start, and at least kappa of them, of a clip on any skeleton
  /// that maps to the standard one, at any rate. The networks see no scene: futures are steered around the meshes
  /// that stand in it (scene/steering.h; points of a cloud are not seen), which may be empty.
  /// Throws Error where fewer frames lie before the start, or an option is out of range.
  Result run(const Clip& clip, const Scene& scene, const Options& options = {}) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace inhabit::anticipate
