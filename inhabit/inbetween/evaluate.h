#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "inhabit/inbetween/motion_autoencoder.h"
#include "inhabit/inbetween/sample.h"
#include "inhabit/inbetween/scene_inbetweener.h"
#include "inhabit/metrics/method.h"
#include "inhabit/metrics/score_table.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"

namespace inhabit::inbetween {

/// A window and the frames of window.given that a method may look at, beside the scene.
struct FillTask {
  const Window& window;
  const std::vector<int64_t>& keys;
};
/// A row of the tables: fills in a window.
using Method = inhabit::Method<FillTask, Clip>;

/// A model as a row: "ours", or what its configuration lacks ("w/o global feature"), with its T* where it is
/// noise-aware.
/// @param options what each window is filled with; keys and seed are the evaluation's.
Method model_method(const std::shared_ptr<const SceneInbetweener>& model, const Options& options);

/// "linear + slerp" and "cubic spline".
std::vector<Method> interpolation_methods();

/// What one method scores over all windows, each number a mean over them.
struct Scores {
  std::string method;
  std::string keyframes;  ///< as key_frames takes it; empty for the real motion and the noisy input
  int64_t runs = 1;       ///< seeds
  Estimate fid;           ///< Frechet distance of motion features; NaN without an autoencoder or for other lengths
  Estimate skating;       ///< fraction of frames with a skating foot
  Estimate jerk;          ///< of the joints, m/s^3
  Estimate jerk_ratio;    ///< over that of the real motion
  Estimate key_error;     ///< mm, mean distance of joints from the true ones at key frames
  Estimate error;         ///< mm, in all frames
  Estimate frame_ratio, vertex_ratio;  ///< of collisions (metrics/collision.h)
  Estimate penetration;                ///< mm, deepest of each window
  /// The same in close-proximity frames (Table 2), those of the true motion less than 8 cm from the scene.
  Estimate close_frame_ratio, close_vertex_ratio, close_penetration;
};

struct Table {
  int64_t windows = 0, close_frames = 0;
  double noise = 0;
  std::vector<Scores> rows;  ///< first the real motion; where there is noise, the noisy poses of all
                             ///< frames as they are; then each choice of keys with each method
};

struct Evaluation {
  std::vector<std::string> keyframes = {"every:60"};  ///< as key_frames takes them
  int64_t seeds = 1;                                  ///< runs of what depends on a seed
  uint64_t seed = 1;
  double noise = 0;                 ///< level of noise on the key frames, see noisy_keys
  std::vector<int64_t> key_joints;  ///< joints that keys between the ends constrain, for MPJE Key; empty: whole poses
  std::function<void(int64_t done, int64_t of)> progress;  ///< called after each filled window
};

/// The clip with noise of `level` on its poses: `level` degrees on every component of the joints' rotations and `level`
/// centimetres on the root (standard deviations); the first and the last frame stay clean (section 4).
Clip noisy_keys(const Clip& clip, double level, uint64_t seed);

/// Fills in every window by every method and measures what comes out. Joints are those of the true poses on the
/// recording's bones: a recording's own joints that its skeleton only comes near to would be an error of every method.
/// The body that collides has the window's betas, or those that fit its joints. Noise, random key frames and what
/// methods draw follow from (seed, run, window) alone, so that methods see the same key frames.
/// @param features may be empty. Throws Error naming method and window where what comes out has another length or is
/// not finite.
Table evaluate(const std::vector<Window>& windows, const std::vector<Method>& methods, MotionAutoencoder features,
               const Evaluation& options);

/// Columns of the paper's tables.
enum class Layout {
  methods,   ///< Tables 1 and 3
  close,     ///< Table 2
  keys,      ///< Table 6
  settings,  ///< Table 8
  seeds      ///< Table 9, with intervals
};

ScoreTable score_table(const Table& table, Layout layout = Layout::methods);
std::string table_text(const Table& table, Layout layout = Layout::methods);
nlohmann::ordered_json table_json(const Table& table);

}  // namespace inhabit::inbetween
