#pragma once
#include <random>

#include "inhabit/motion/clip.h"
#include "inhabit/synth/body_sweep.h"
#include "inhabit/synth/layout.h"

namespace inhabit {

/// Throws Error for a fraction of places that is not from 0 to 1.
void check_passages(double tried);

/// Puts pairs of pieces beside somebody's walk, one to the left and one to the right, so that arms and hands have
/// something to keep clear of. Places are at least 1.2 m of path apart, where the root goes faster than 0.5 m/s. Both
/// pieces are of one kind. Each is at least 20 cm from the root's path and, over the whole clip, 4 cm from the body's
/// capsules (6.5 cm from those of hands, whose thumbs stick out), and up to 15 cm farther than it need be: the two are
/// at most 1.5 m apart.
/// @param sweep of `clip`. @param tried fraction of the places, 0 to 1; 0 draws nothing from `random`. Returns the
/// number of pairs.
int add_passages(Layout& layout, const Clip& clip, const BodySweep& sweep, double tried, std::mt19937_64& random);

}  // namespace inhabit
