#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "inhabit/inbetween/controls.h"
#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/sampler.h"
#include "inhabit/metrics/immersion.h"
#include "inhabit/motion/clip.h"
#include "inhabit/progress.h"
#include "inhabit/scene/scene.h"

namespace inhabit::inbetween {

/// What of a model's work is wanted; less than all of it is for measuring what each part does.
enum class Stage {
  finished,  ///< brought to the keys, refined
  network,   ///< as the network says it, not imposed at the keys either
  baseline   ///< what the network starts from and adds to: the keys' interpolation, around obstacles where it does so
};

/// How the baseline goes from key to key where the straight line is blocked.
enum class Detours {
  learned,   ///< as PathNet says; where it knows none, and by a model without it, as searched
  searched,  ///< as A* says
  straight   ///< through what stands there: the denoiser alone goes around
};
/// By their names.
const std::map<std::string, Detours>& detours_by_name();
/// Throws Error for a name that is none of theirs.
Detours detours_named(const std::string& name);

/// What motion is asked for, beside the clip and the scene.
struct Options {
  std::vector<int64_t> keys;  ///< key frames of the clip, in order (see key_frames); empty: its ends
  torch::Tensor key_groups;   ///< (25) groups that keys between the ends constrain; undefined: whole poses
  /// Level of noise on whole keys between the ends, so many degrees and cm, which are cleaned by models that take it
  /// (Config::takes_noise). Nothing: 0 or, of models for noisy keys (inference.noisy_keys), as all frames of the clip
  /// tell it (measured_noise), but no less than 0.5; of clips with nothing between the keys (poses_at_times) 1.
  std::optional<double> noise;
  int64_t steps = 0;  ///< evaluations of the denoiser; 0: the model's own (config().inference.steps)
  Sampler sampler = Sampler::dpm_solver;  ///< how the evaluations are put together
  uint64_t seed = 1;                      ///< what the noise follows from that motion begins as
  /// How much of the motion's course is left to the seed, by models of residual motion: 0 the likeliest course, 1 any
  /// that people take (with_temperature, learned_detours), at most 2. Nothing: 0, of several samples 1. Other models
  /// draw all of the noise.
  std::optional<double> temperature;
  Controls controls;                   ///< for models of residual motion
  bool refine = true;                  ///< feet stand, nobody is inside the scene (refine/)
  Stage stage = Stage::finished;       ///< how far the model's work is done
  Detours detours = Detours::learned;  ///< around what stands between keys
  bool collisions = false;             ///< Result::collides is found
  std::string name = "motion";         ///< what errors call the clip
  std::string keys_name = "keys";      ///< what errors call the key frames
  bool standard = false;               ///< the motion is wanted on the standard skeleton alone
  Progress progress;                   ///< evaluations; may be empty
};

/// The motion that was made, and what was found out on the way.
struct Result {
  Clip motion;     ///< on the standard skeleton at the model's rate, from the first key frame to the last
  Clip on_source;  ///< the same on the clip's own skeleton, at its rate, key poses bit by bit (motion/transfer.h); of a
                   ///< clip without rotations `motion` at its rate; empty where Options::standard is set
  std::vector<int64_t> keys;       ///< key frames of it: those asked for, at the nearest of its frames
  Clip key_poses;                  ///< (K frames) the poses asked for there
  double noise = 0;                ///< level of noise that they were taken to have (Options::noise)
  Scene scene;                     ///< what was looked at: the one given or, where that is empty, an assumed flat floor
  bool floor_assumed = false;      ///< `scene` is that assumed floor
  std::vector<int64_t> unreached;  ///< of `keys`: whose straight line is blocked and that no path leads to in time
  std::vector<double> contact_gaps;  ///< metres that each contact of the controls is missed by, at most; one where
                                     ///< nobody can be in time is not tried
  torch::Tensor key_collides;        ///< (K) bool: the key pose is inside the scene; undefined but for Stage::finished
  torch::Tensor collides;            ///< (T) bool: the motion is; undefined unless asked for
  std::vector<Immersion> key_immersions;  ///< of the keys that collide: `frame` is one of `keys`
  std::vector<Immersion> immersions;      ///< of each stretch of `collides`
};

/// Scene-aware motion in-betweening: key frames and a room in, motion that respects both out. On the CPU. Safe to use
/// from several threads.
///
///   const auto inbetweener = inbetween::SceneInbetweener::load("inbetween-compact.safetensors");
///   inbetween::Result r = inbetweener.run(clip, scene, {key_frames("every:60", clip.frames())});   // r.motion
class SceneInbetweener {
 public:
  /// Shares the network's weights and puts it into evaluation mode.
  explicit SceneInbetweener(const Networks& networks);
  /// Throws Error naming the file where it is no model of in-betweening.
  static SceneInbetweener load(const std::string& path);
  ~SceneInbetweener();
  SceneInbetweener(SceneInbetweener&&) noexcept;  ///< moves; what was moved from may only be destroyed

  const Config& config() const;  ///< sizes and settings that the network was made with
  /// Whether the network adds to an interpolation of the keys: Stage::baseline is refused else.
  bool has_baseline() const;

  /// Whether the model has PathNet: its baseline then depends on the seed.
  bool has_path_net() const;

  /// The motion between the key frames of a clip on any skeleton that maps to the standard one, at any rate; what it
  /// holds elsewhere is not looked at. Key poses come out as they went in, but those between the ends that have
  /// noise (Options::noise) or are a noise-aware model's (config().t_star > 0), which are cleaned. Longer clips are
  /// filled window by window, each going on from the last 60 frames of the one before. The same clip, scene and options
  /// give the same motion. With Controls::loop the motion is made twice in a row,
  /// going on from the first to the second, and both are mixed. @param scene as read; without meshes and points a flat
  /// floor under the feet is assumed. Throws Error where key frames are fewer than two, out of order, outside the clip,
  /// not finite or too far apart for the model, or an option does not fit it.
  Result run(const Clip& clip, const Scene& scene, const Options& options = {}) const;

  /// So many motions between the same keys, with seeds from options.seed on, which differ in their course unless
  /// Options::temperature says otherwise. options.progress counts the evaluations of all. @param samples 1 to 1000;
  /// Throws Error("samples", ...) else.
  std::vector<Result> run_samples(const Clip& clip, const Scene& scene, const Options& options, int64_t samples) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace inhabit::inbetween
