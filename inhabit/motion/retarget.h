#pragma once
#include <string>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// A motion on the standard 22 joints from one on any skeleton whose joints find_landmarks knows.
///
/// `joints` (T, 22, 3) are the source's own positions of limbs, neck and head, where it has such joints. The three
/// spine joints lie on the source's curve from pelvis to neck, at the built-in body's fractions of its length. Spine1
/// rotates with the pelvis, spine3 with the thorax, and so do the collars where the source has none off the midline.
/// `skeleton` is the standard one with the person's own bones: lengths are medians over the frames; the rest pose is
/// the built-in body's T-pose, but for hips and what hangs on the thorax, whose places are the person's. `rotations`
/// and `trans` pose it: bones point at the source's joints, twist is that of the source's rotations (set once so that
/// elbows and knees bend about their hinges), and without those that of the bending planes. They serve the built-in
/// body as well. A skeleton whose first 22 joints are the standard ones and that has rotations (SMPL, SMPL-H, SMPL-X)
/// is cut to these.
///
/// Frame rate, actions, hand targets, objects and, where the joint has a counterpart, contacts are kept. Bones are
/// rigid again: what joints translate is in `joints` alone. Throws Error(subject, ...) for skeletons that cannot be
/// mapped, or bones without length.
Clip retarget(const Clip& source, const std::string& subject);

/// The same where the skeleton can be mapped; the motion as it is where it cannot. So pages show a body where they can,
/// and a bare skeleton otherwise.
Clip retarget_if_known(const Clip& source, const std::string& subject);

}  // namespace inhabit
