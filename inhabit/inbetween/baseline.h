#pragma once
#include <torch/types.h>

#include "inhabit/inbetween/detour_legs.h"
#include "inhabit/inbetween/poses.h"

namespace inhabit::inbetween {

/// How far a frame is from those that are constrained.
struct KeyDistance {
  int before = -1;  ///< frames since the last constrained one, 0 in one; -1: there is none
  int after = -1;   ///< frames to the next constrained one, 0 in one; -1: there is none

  /// d d' / (d + d') of the two distances, frames: what the variance of a random walk between two known places is
  /// proportional to. Where only one side is constrained, its distance. 0 in constrained frames.
  float bridge() const;
};

/// The interpolated baseline of a window's keys, and the frames of reference that the residual motion is told in. T
/// frames; world, the floor at height 0.
struct Baseline {
  Poses poses;                 ///< linear + slerp between keys, constant before the first and after the last
  std::vector<float> heading;  ///< (T) radians, of `poses`
  std::vector<KeyDistance> pose_distance;  ///< (T) from keys with a whole pose
  std::vector<KeyDistance> root_distance;  ///< (T) from keys with the root's place
  std::vector<float> noise;                ///< (T) level of noise on the keys; 0 in frames that are exact
  DetourLegs legs;                         ///< where it goes around obstacles
  torch::Tensor targets;  ///< (T, 22, 4) metres from the baseline's joint to where a partial or a noisy key has it,
                          ///< heading frame; 1 where it has one, else 0
};

/// How noisy keys are.
struct KeyNoise {
  double level = 0;         ///< so many degrees and cm, see with_noise
  std::vector<char> exact;  ///< (T) frames that have no noise; not looked at where the level is 0
  double rate = 30;         ///< frames a second
};

/// @param keys read in key frames only. @param groups (T, 25) what each frame constrains (keyframes.h): whole poses,
/// or positions of joints and with the pelvis's the root. The first frame must be a whole key. @param detours (T, 2)
/// metres along x and z that the root's line is shifted by (obstacle_detours.h), with which the body rotates;
/// undefined: none. @param noise whole keys that have some are smoothed first (key_smoother.h), which leaves targets at
/// their own joints
Baseline baseline_of(const Poses& keys, const torch::Tensor& groups, const torch::Tensor& detours = {},
                     const KeyNoise& noise = {});

}  // namespace inhabit::inbetween
