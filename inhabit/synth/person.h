#pragma once
#include <random>

#include "inhabit/body/body_model.h"
#include "inhabit/motion/clip.h"
#include "inhabit/synth/room.h"

namespace inhabit {

/// Frames a second of every clip that is made.
inline constexpr double kSynthRate = 30;

/// How long somebody lives.
struct LifeOptions {
  double seconds = 12;  ///< length of the clip
};

/// A person living in `room` for a while: walks around the furniture, turns, sits down and stands up with the hands
/// free or on arm rests or the seat, gestures, leans back, reaches for and touches tables and shelves, stands about.
/// Stature, limb lengths, girth and style are drawn anew for each clip.
///
/// The clip has 30 frames a second and every annotation of Clip, exact: rotations, trans, betas, joints, action,
/// contact (feet on the floor: 7, 8 heel and 10, 11 ball; 0, 1, 2 on a seat; 6, 9 on a back rest; 20, 21 hands on a
/// surface), hand_targets, object_names (as in Room::scene()) and object_pose of the furniture used.
///
/// Several lives are drawn when need be, until one keeps the joint limits and stays out of walls and furniture
/// (capsules no deeper than 2 cm in anything not sat or leaned on); at most 48, the best is taken. Lives longer than 12
/// s go on from there by pieces of 12 s, drawn in the same way.
Clip live(const Room& room, const BodyModel& body, std::mt19937_64& random, const LifeOptions& options = {});

}  // namespace inhabit
