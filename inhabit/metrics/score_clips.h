#pragma once
#include <string>
#include <vector>

#include "inhabit/metrics/score_motions.h"
#include "inhabit/motion/clip.h"
#include "inhabit/progress.h"
#include "inhabit/scene/scene.h"

namespace inhabit {

// Scores of how anybody's motion moves and of what it runs into: the measures of `inhabit eval` over whole files.

/// One motion on the standard skeleton at the score's rate, and what errors call it.
struct ScoredClip {
  std::string name;      ///< its file
  Clip clip;             ///< at the score's rate, with the rotations that it has
  double file_rate = 0;  ///< frames a second of the motion as it was read: what its frames are counted in
};

/// @param rate frames a second to score at. @param least frames that are needed at that rate. Throws Error(name, ...)
/// where the skeleton cannot be mapped or the motion is shorter, in the frames that it has itself.
ScoredClip scored_clip(const Clip& clip, double rate, int64_t least, const std::string& name);

/// The joints of each, as score_motions.h takes them.
std::vector<NamedMotion> joints_of(const std::vector<ScoredClip>& clips);

/// score_ndms of motions and real ones that are all on the bones of the first real one, as evaluate() of anticipation
/// has them on those of the training data.
NdmsScore score_ndms(const std::vector<ScoredClip>& motions, const std::vector<ScoredClip>& reference,
                     const NdmsOptions& options);

/// The clip over the floor y = 0: that of the scene under the feet, or without a scene the one that the feet stand on.
Clip over_floor(const Clip& clip, const Scene& scene);
/// The same of each.
std::vector<ScoredClip> over_floors(std::vector<ScoredClip> clips, const Scene& scene = {});

/// How much the feet of motions slide.
struct SkatingScore {
  double foot_skating = 0;      ///< fraction of all frames (metrics/foot_skating.h), which is per frame: 30 a second
  std::vector<double> by_clip;  ///< of each
};

/// @param clips as over_floors gives them, of two frames or more each.
SkatingScore score_skating(const std::vector<ScoredClip>& clips);

/// How motions move, means over the frames of all of them (metrics/dynamics.h).
struct JerkScore {
  double jerk = 0;              ///< m/s^3
  double acceleration = 0;      ///< m/s^2
  double speed = 0;             ///< of the root over the ground, m/s
  std::vector<double> by_clip;  ///< jerk of each
};

/// @param clips of four frames or more each.
JerkScore score_jerk(const std::vector<ScoredClip>& clips);

/// The skin against a scene, without tolerance where `exact` is said (metrics/collision.h).
struct PenetrationScore {
  double frame_ratio = 0;            ///< fraction of all frames in which skin collides
  double vertex_ratio = 0;           ///< fraction of the skin's vertices that collide, mean over all frames
  double penetration_max = 0;        ///< metres, the deepest of each clip, the mean over clips
  double exact_frame_ratio = 0;      ///< as frame_ratio
  double exact_vertex_ratio = 0;     ///< as vertex_ratio
  double exact_penetration_max = 0;  ///< as penetration_max
  /// One motion.
  struct OfClip {
    double depth = 0;        ///< metres
    int64_t frame = -1;      ///< of the deepest place, counted in the file's own frames; -1 where none collides
    double frame_ratio = 0;  ///< fraction of its frames in which skin collides
    std::string object;      ///< that the deepest place is in (scene/objects.h); empty where none collides
  };
  std::vector<OfClip> by_clip;  ///< in the order of the clips
};

/// The body has the clip's betas or, where there are none, the shape that fits its bones. @param clips where the scene
/// is, with rotations. @param progress counts clips; may be empty
PenetrationScore score_penetration(const std::vector<ScoredClip>& clips, const Scene& scene,
                                   const Progress& progress = {});

}  // namespace inhabit
