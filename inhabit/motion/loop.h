#pragma once
#include <string>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// The clip as one that can be repeated: its last pose is its first again, where the last stands and facing as that
/// does, and what follows on the first follows on the last. It is `seconds` shorter: the end is mixed into the start
/// over that time (a third of the clip at most), moved to where the start is. Annotations are those of the frames that
/// stay. Throws Error(subject, ...) where it has fewer than four frames, or neither rotations nor standard names.
Clip looped(const Clip& clip, double seconds, const std::string& subject);

}  // namespace inhabit
