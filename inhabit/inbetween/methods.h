#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "inhabit/inbetween/sample.h"
#include "inhabit/inbetween/scene_inbetweener.h"
#include "inhabit/metrics/method.h"
#include "inhabit/motion/clip.h"

namespace inhabit::inbetween {

/// A window and the frames of window.conditioning that a method may look at, beside the scene.
struct FillTask {
  const Window& window;                  ///< its conditioning and its scene; its truth is not to be looked at
  const std::vector<int64_t>& keys;      ///< key frames, in order, the window's first and last among them
  std::vector<int64_t> key_joints = {};  ///< that keys between the ends constrain; empty: whole poses
  double noise = 0;                      ///< level of noise on the keys between the ends
};
/// A row of the tables: fills in a window. Called from several threads at once.
using Method = inhabit::Method<FillTask, Clip>;

/// What a model's row is called where the user says nothing else: "ours", or what its configuration lacks ("w/o global
/// feature"), with its T* where it is noise-aware.
std::string row_name(const Config& config);

/// A model as a row `name`.
/// @param options what each window is filled with; keys and seed are the evaluation's.
Method model_method(const std::string& name, const std::shared_ptr<const SceneInbetweener>& model,
                    const Options& options);

/// "linear + slerp", "cubic spline", and both with detours around obstacles (interpolate_around.h). Where keys
/// are `noisy` also "smoother" (key_smoother.h), which is told how noisy.
std::vector<Method> interpolation_methods(bool noisy = false);

/// The post-processing that is the same for every method, in two passes. refine_generated brings the motion to the keys
/// and changes the frames between them smoothly along. refine_clip then looks after contacts, the scene and joint
/// limits, with the keys as hard constraints. Noisy keys count by their noise, partial keys by their joints; the first
/// and the last key are exact.
/// @param motion on the standard skeleton with rotations
Clip post_processed(const Clip& motion, const FillTask& task);

/// The method "NAME + refine": `method`, then post_processed.
Method with_refine(const Method& method);

/// The interpolations, and after each the same refined where `refine`.
std::vector<Method> interpolation_rows(bool noisy, bool refine);

/// Rows of a model: what it starts from ("NAME, input", where it has that and `input`), what its network says ("NAME,
/// raw"), and the refined motion that it gives in the end ("NAME").
std::vector<Method> model_rows(const std::string& name, const Networks& networks, Options options, bool input = true);

/// Other settings that a model is measured with.
struct OtherSettings {
  std::string name;  ///< of their rows, behind the model's
  /// Of its configuration, as set_used takes them, "detours=NAME", as detours_named takes it (Options::detours), and
  /// "temperature=NUMBER" (Options::temperature).
  std::vector<std::string> settings;
};

/// Of "NAME: KEY=VALUE ...". Throws Error("--row TEXT", ...) where it is none.
OtherSettings other_settings(const std::string& row);

/// Sets OtherSettings::settings in a model's configuration and in what its windows are filled with. Throws Error naming
/// the setting that cannot be. @return whether the detours are set
bool take_settings(std::vector<std::string> settings, Config& config, Options& options);

/// The models that an evaluation measures, and how.
struct MeasuredModels {
  std::vector<std::pair<std::string, Networks>> networks;  ///< each behind its file's name, for errors
  std::vector<OtherSettings> others = {};                  ///< each model has further rows with these
  std::vector<int> t_star = {};  ///< T* of noise-aware models, with rows for each; empty: the one that a model has
  Options options = {};          ///< what windows are filled with; keys and seed are the evaluation's
  bool refine = true;            ///< interpolations have rows after the refinement that ours has, too
};

/// All rows of an evaluation: the interpolations, which know whole poses only and are left away where the options have
/// partial keys; then those of each model as it is and with each of the other settings. "NAME, input" is the same with
/// settings of the configuration and has no further row for them.
/// @param noisy the keys are. Throws Error naming the file where T* is asked for of a model that was not trained on
/// noisy keys, and naming a setting that is not one of how a model is used.
std::vector<Method> evaluation_rows(const MeasuredModels& models, bool noisy = false);

}  // namespace inhabit::inbetween
