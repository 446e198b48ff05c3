#pragma once
#include <random>

#include "inhabit/body/body_model.h"
#include "inhabit/motion/clip.h"
#include "inhabit/synth/body_sweep.h"
#include "inhabit/synth/layout.h"

namespace inhabit {

/// A chord is the straight path between two poses of a motion: the root moves linearly, rotations by slerp. Where the
/// motion itself took another path, furniture can stand on the chord.
struct ChordOptions {
  double tried = 0.7;  ///< fraction of the chords that furniture is tried on
  int shortest = 30;   ///< frames from one end to the other, at least
  int longest = 120;   ///< at most
};

/// Throws Error where an option is out of range.
void check_chords(const ChordOptions& options);

/// Adds pieces that the body meets on chords of `clip` (at least 5 cm deep, by its capsules), in as many places along
/// the clip as there is room, and 4 cm or more away from it on its true path. @param sweep of the clip. Returns the
/// number of pieces.
int add_on_chords(Layout& layout, const Clip& clip, const BodyModel& body, const BodySweep& sweep,
                  const ChordOptions& options, std::mt19937_64& random);

}  // namespace inhabit
