#pragma once
#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"

namespace inhabit::interact {

/// A generated motion fitted to its contacts and its scene by the trajectory solver (refine/refine_clip.h; appendix 3):
/// palms are on their contacts from where they come near them to where they leave them, feet stand, the pelvis stays
/// where it was but for what lifts the flesh out of the seat, and no skin is over 2 cm deep in the chair. Contacts that
/// a palm misses by over 25 cm stay missed.
/// @param motion with Clip::hand_targets: the contact in the frames in which it is reached for or held.
Clip fit_contacts(const Clip& motion, const Scene& scene);

/// (T, 2) metres from the left and the right palm to their contacts; NaN where there is none.
torch::Tensor contact_distances(const Clip& motion);

}  // namespace inhabit::interact
