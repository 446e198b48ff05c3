#pragma once
#include <random>

#include "inhabit/motion/clip.h"
#include "inhabit/synth/body_sweep.h"
#include "inhabit/synth/layout.h"

namespace inhabit {

/// Passages that somebody walks through: at places along the walks of a clip (its root goes faster than 0.5 m/s), 1.2 m
/// apart, two pieces of one kind stand to the left and to the right of the path, as near as the body lets them: 4 cm
/// from its capsules over the whole clip, or up to 15 cm more. Openings are at most 1.3 m wide. So what arms and hands
/// must keep clear of stands next to them.
/// @param sweep of the clip. @param tried fraction of the places, 0 to 1. Returns the number of passages.
int add_passages(Layout& layout, const Clip& clip, const BodySweep& sweep, double tried, std::mt19937_64& random);

}  // namespace inhabit
