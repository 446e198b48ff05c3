#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/sampler.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"

namespace inhabit::inbetween {

/// Evaluations of the denoiser for a window: few, as more collide more and are else no better beyond the spread of
/// seeds (docs/inbetweening.md).
inline constexpr int64_t kDefaultSteps = 2;

struct Options {
  std::vector<int64_t> keys;  ///< frames that are given, in order: at least the first and the last (see key_frames)
  torch::Tensor given;        ///< (25) groups that the keys between the ends give; undefined: whole poses
  int64_t steps = kDefaultSteps;
  Sampler sampler = Sampler::dpm_solver;
  uint64_t seed = 1;
  bool clean_feet = true;                                   ///< feet stand, step and are lifted (motion/feet.h)
  std::function<void(int64_t done, int64_t all)> progress;  ///< evaluations; may be empty
};

/// Scene-aware motion in-betweening: key frames and a room in, motion that respects both out.
///
///   const auto inbetweener = SceneInbetweener::load("inbetween-compact.safetensors");
///   Clip filled = inbetweener.fill(clip, scene, {key_frames("every:60", clip.frames())});
class SceneInbetweener {
 public:
  explicit SceneInbetweener(Networks networks);
  /// Throws Error naming the file where it is no model of in-betweening.
  static SceneInbetweener load(const std::string& path);

  const Config& config() const { return networks_.config; }

  /// The motion between the key frames; what `clip` holds elsewhere is not looked at. Key poses come out as they went
  /// in, but those between the ends of a noise-aware model (config().t_star > 0), which it cleans. Longer clips are
  /// filled window by window, each going on from the last 60 frames of the one before. The same clip, scene and request
  /// give the same motion.
  /// The floor is y = 0, or where the feet of the key poses stay higher or lower by more than 10 cm, beneath them.
  /// @param clip on the standard skeleton with rotations, config().rate frames a second (retarget, resample).
  /// Throws Error where it is not, or key frames are missing, out of order, outside the clip or too far apart.
  Clip fill(const Clip& clip, const Scene& scene, const Options& request) const;

 private:
  Networks networks_;
  DiffusionSchedule schedule_;
};

}  // namespace inhabit::inbetween
