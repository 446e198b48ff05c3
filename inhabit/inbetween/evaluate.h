#pragma once
#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "inhabit/data/measured_parts.h"
#include "inhabit/inbetween/methods.h"
#include "inhabit/inbetween/motion_autoencoder.h"
#include "inhabit/metrics/collision.h"
#include "inhabit/metrics/score_table.h"
#include "inhabit/progress.h"

namespace inhabit::inbetween {

/// One number of a row.
struct Score {
  double mean = std::numeric_limits<double>::quiet_NaN();  ///< over windows and runs; NaN: cannot be measured
  double interval = 0;    ///< half of its 95 % interval by bootstrap over windows (metrics/bootstrap.h)
  double seeds = 0;       ///< half of the 95 % interval over runs with different seeds, by Student's t
  double difference = 0;  ///< from the row that Evaluation::against names, and half of its interval, by the same
  double difference_interval = 0;  ///< resamples of windows in both rows
};

/// What one method scores over all windows.
struct Scores {
  std::string method;     ///< its name; of the first rows "real motion" or "recording", and "noisy input"
  std::string keyframes;  ///< as key_frames takes it; empty for the real motion and the noisy input
  int64_t runs = 1;       ///< seeds
  /// Frechet distance of motion features from those of the real motion; NaN without an autoencoder or for other
  /// lengths. Of the real motion: between halves of its windows, the mean over random halves.
  Score fid;
  Score skating;             ///< fraction of frames with a foot that slides (metrics/foot_skating.h)
  Score jerk;                ///< m/s^3, of the joints
  Score jerk_ratio;          ///< the jerk over that of the real motion; 1 is as smooth
  Score acceleration;        ///< m/s^2, of the joints
  Score key_error;           ///< mm, mean distance of the joints from the true ones at key frames (MPJE Key)
  Score error;               ///< mm, the same in all frames (MPJE All)
  Score apart;               ///< mm, mean distance of the joints between runs with different seeds; NaN for one run
  Score frame_ratio;         ///< fraction of frames in which skin collides (metrics/collision.h)
  Score vertex_ratio;        ///< fraction of the skin's vertices that collide, mean over frames
  Score penetration;         ///< mm, of the deepest vertex that collides in each window
  Score exact_frames;        ///< as frame_ratio, without tolerance: skin that is inside at all collides
  Score exact_vertices;      ///< as vertex_ratio, without tolerance
  Score exact_depth;         ///< mm, as penetration, without tolerance
  Score close_frame_ratio;   ///< as frame_ratio, in frames in which the true body is close to the scene (Table 2)
  Score close_vertex_ratio;  ///< as vertex_ratio, in close frames
  Score close_penetration;   ///< mm, as penetration, in close frames
  Score upright_frames;      ///< as frame_ratio, in close frames in which nobody sits
  Score upright_vertices;    ///< as vertex_ratio, in close frames in which nobody sits
  Score upright_depth;       ///< mm, as penetration, in close frames in which nobody sits
};

/// What evaluate() measured, a row for each method and choice of key frames.
struct Table {
  int64_t windows = 0;         ///< that each row filled
  int64_t close_frames = 0;    ///< frames of the true motion within kCloseProximity of the scene; 0 without a truth
  int64_t upright_frames = 0;  ///< of these, in which nobody sits
  int64_t dimensions = 0;      ///< of the features that fid is taken over
  double noise = 0;            ///< level of noise on the key frames, so many degrees and cm
  bool truth = true;           ///< the recordings are the truth
  std::string against;         ///< the row that differences are from
  std::vector<Scores> rows;    ///< first the real motion; where there is noise, the noisy poses of all
                               ///< frames as they are; then each choice of keys with each method
};

/// How methods are evaluated.
struct Evaluation {
  std::vector<std::string> keyframes = {"every:60"};  ///< as key_frames takes them
  int64_t seeds = 1;                                  ///< runs of what depends on a seed
  uint64_t seed = 1;                                  ///< what noise, random key frames and methods' draws follow from
  double noise = 0;                                   ///< level of noise on the key frames, see noisy_keys
  std::vector<int64_t> key_joints;  ///< joints that keys between the ends constrain, for MPJE Key; empty: whole poses
  bool truth = true;  ///< false: the recordings are noisy themselves; nothing is measured that needs a truth, and
                      ///< MPJE Key is the distance from the recording's poses (Table 4)
  CollisionTolerance tolerance;  ///< of all collisions but the exact ones
  std::string against;           ///< row that differences are taken from; empty: the first method's
  bool parallel = true;          ///< methods are called on all of LibTorch's threads
  Progress progress;             ///< called after each filled window, once at a time
  MeasuredParts parts;           ///< only windows of its shard are filled, those in one scene together
};

/// The clip with noise of `level` on its poses: `level` degrees on every component of the joints' rotations and `level`
/// centimetres on the root (standard deviations); the first and the last frame stay clean (section 4).
Clip noisy_keys(const Clip& clip, double level, uint64_t seed);

/// Fills in every window by every method and measures what comes out. Joints are those of the true poses on the
/// recording's bones: a recording's own joints that its skeleton only comes near to would be an error of every method.
/// The body that collides has the window's betas, or those that fit its joints. Noise, random key frames and what
/// methods draw follow from (seed, run, window) alone, so that methods see the same key frames. The Frechet distance is
/// taken over as many principal components of the real motion's features as there are tens of windows, at most all.
/// @param features may be empty. Throws Error naming method and window where what comes out has another length or is
/// not finite, and where no row is called `against`. Without rows, other parts are still to come.
Table evaluate(const std::vector<Window>& windows, const std::vector<Method>& methods, MotionAutoencoder features,
               const Evaluation& options);

/// Columns of the paper's tables.
enum class Layout {
  methods,     ///< Tables 1 and 3
  close,       ///< Table 2, and without those who sit
  recordings,  ///< Table 4: what needs no truth
  keys,        ///< Table 6
  settings,    ///< Table 8
  seeds,       ///< Table 9, with intervals over seeds
  collisions   ///< with and without tolerance
};
/// What users call them: their own names.
const std::map<std::string, Layout>& layouts_by_name();

/// The layout that is asked for or, where the table has no truth, the one of what needs none (`collisions` needs none
/// either).
Layout layout_for(const Table& table, Layout asked);

/// @param differences the rows' differences from the one that the table is against
ScoreTable score_table(const Table& table, Layout layout = Layout::methods, bool differences = false);
/// The table in a layout as text, with 95 % intervals behind means; its notes say what they are over.
std::string table_text(const Table& table, Layout layout = Layout::methods, bool differences = false);
/// Every score of every row as JSON, whatever the layout: mean, its 95 % intervals over windows and over seeds, and its
/// difference from the row that the table is against; null where there is no value.
nlohmann::ordered_json table_json(const Table& table);

}  // namespace inhabit::inbetween
