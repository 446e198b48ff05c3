#pragma once
#include <vector>

#include "inhabit/motion/clip.h"
#include "inhabit/view/page.h"

namespace inhabit::interact {

/// The labels of a native data set's clip (labels.h) as strips for a page: local phase of the left and the right hand,
/// global phase (its fraction), action, and the contacts of the left and the right hand ("0.31 0.62 -0.18", world
/// metres) while they are reached for or held. Empty where hands touch nothing and nobody sits, or contacts are
/// unknown.
std::vector<PageTrack> label_tracks(const Clip& clip);

}  // namespace inhabit::interact
