#pragma once
#include <torch/types.h>

#include <array>
#include <cstdint>
#include <vector>

#include "inhabit/metrics/collision.h"
#include "inhabit/motion/clip.h"

namespace inhabit::inbetween {

/// Metres (4.1): frames of the true motion nearer to the scene than this are Table 2's.
inline constexpr double kCloseProximity = 0.08;

/// What is measured of a filled window. Each is a ratio of sums over windows.
enum Measure : size_t {
  kSkating,       ///< fraction of frames with a skating foot
  kJerk,          ///< of the joints, m/s^3
  kJerkRatio,     ///< over that of the real motion
  kAcceleration,  ///< of the joints, m/s^2
  kKeyError,      ///< mm, mean distance of the joints from the true ones at key frames
  kError,         ///< mm, from the true ones in all frames
  kApart,         ///< mm, between runs with different seeds, over all pairs of them
  kFrames,        ///< that collide (metrics/collision.h), as a fraction
  kVertices,      ///< of the skin that collide
  kPenetration,   ///< mm, deepest of each window
  kExactFrames,   ///< the same three without tolerance
  kExactVertices,
  kExactPenetration,
  kCloseFrames,  ///< the three of collisions in close frames
  kCloseVertices,
  kClosePenetration,
  kUprightFrames,  ///< and in those of them in which nobody sits
  kUprightVertices,
  kUprightPenetration,
  kMeasures
};

/// What is measured of one window.
struct WindowScores {
  std::array<double, kMeasures> sum{};     ///< by Measure, what is summed over windows
  std::array<double, kMeasures> weight{};  ///< by Measure, what those sums are divided by; 0: not measured here
};

/// (T) bool: the clip's action is called sit..., lean_back or stand_up, or its pelvis is lower over the floor y = 0
/// than 0.85 of thigh and shin are long.
torch::Tensor sitting_frames(const Clip& clip);

/// A window as it is compared with.
struct Compared {
  const Clip& truth;            ///< of the same length
  bool known = true;            ///< the truth is one: else measures that need it have no weight
  std::vector<int64_t> keys;    ///< frames with key poses
  std::vector<int64_t> joints;  ///< that keys between the ends gave; empty: all of every key
  torch::Tensor close;          ///< (T) bool: frames in which the truth is close to the scene; undefined: no weight
  torch::Tensor upright;        ///< (T) bool: those of them in which nobody sits; undefined: no weight
};
/// Scores of a filled window. Collisions need the clip's rotations. kApart, which is about several runs, is left at
/// weight 0. @param tolerance of all collisions but the exact ones
WindowScores window_scores(const Clip& clip, const Compared& with, const CollisionMeter& meter,
                           const CollisionTolerance& tolerance = {});

}  // namespace inhabit::inbetween
