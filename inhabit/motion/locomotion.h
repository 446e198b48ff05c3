#pragma once
#include "inhabit/motion/clip.h"

namespace inhabit {

/// The joint that legs, arms and head hang on: the pelvis where find_landmarks knows the skeleton, else the first
/// joint with several branches (children that have children), else the root.
int body_joint(const Skeleton& skeleton);

/// In some files the root stands at the origin ("joint_Root") and a joint between it and the body, the carrier, moves
/// ("Hips"). Here the root takes that motion over, so that trans is where the person goes. The bones from the root to
/// the carrier become rigid and, where they carried the motion, vertical: as long as they were high in the median.
/// Joints below the carrier stay exactly where they are, others keep their places by translations. clip.file keeps what
/// restore_trajectory needs. Nothing happens where the root goes as far as the carrier does relative to it.
/// @return the carrier, or -1 where nothing happened.
int carry_by_root(Clip& clip);

/// Undoes carry_by_root: the root stands where its file had it, the carrier translates. The clip as it is where there
/// is no carrier, or where in the file the root, or a joint between the two, did not stand.
Clip restore_trajectory(const Clip& clip);

/// Sets clip.translations from places (T, J, 3) relative to the parents, or leaves it undefined where every joint stays
/// within 0.02 mm of its skeleton offset. Needs rotations and trans; joints follow.
void set_translations(Clip& clip, torch::Tensor places);

}  // namespace inhabit
