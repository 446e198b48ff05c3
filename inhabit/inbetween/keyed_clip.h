#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "inhabit/inbetween/scene_inbetweener.h"
#include "inhabit/motion/transfer.h"

namespace inhabit::inbetween {

/// Key poses on the standard skeleton and where they stand at a model's rate.
struct KeyedClip {
  Clip clip;                  ///< the frames `keys` of it are the poses; those between repeat the pose before
  std::vector<int64_t> keys;  ///< in order, the first 0, the last its last frame
  SourcePoses source;         ///< the same poses on the skeleton that they came on
  Controls controls;  ///< those asked for, without contacts where nobody can be in time; a weight for each of `keys`,
                      ///< or none
};

/// The key poses that options ask for. Poses at the nearest frames of `rate`; of several in one the first, but the
/// clip's last stands. Throws Error as SceneInbetweener::run does.
KeyedClip keyed_clip(const Clip& clip, const Options& options, double rate);

/// The keys twice in a row, the second time going on from where the first ends, with their controls. Of a clip whose
/// last pose is its first (with_looped_end); without what it was on its own skeleton.
KeyedClip twice(const KeyedClip& keyed);

/// What fills both halves of a clip that is twice in a row as one: the first half, at whose start the second is mixed
/// in. So what follows on its last frame is what follows on its first.
Clip folded(const Clip& filled);

}  // namespace inhabit::inbetween
