#pragma once
#include <torch/types.h>

#include <Eigen/Core>
#include <vector>

#include "inhabit/refine/trajectory.h"

namespace inhabit::refine {

/// White noise on each component of a track, and the jerk that the motion itself has, as standard deviations: metres
/// and m/s^3, or radians and rad/s^3.
struct Level {
  double noise = 0;  ///< metres, or radians
  double jerk = 0;   ///< m/s^3, or rad/s^3
};

/// The level of a track, from its third differences in time. Noise n shows as n^2 (2 sin(w / 2))^6 in their spectrum
/// and is all that there is at the highest frequencies. The jerk is that with which a smoother of white jerk has the
/// least risk (Stein's unbiased estimate). Fewer than two differences tell nothing: zeros.
Level level_of(const Track& third_differences, double rate);

/// Noise of every joint's local rotation (radians) and of the root's translation (metres); medians over the joints of
/// their places' noise (metres) and jerk (m/s^3).
struct Levels {
  std::vector<double> rotations;  ///< (joints) radians, of each local rotation
  double root = 0;                ///< metres, of the root's translation
  double place = 0;               ///< metres, of joints' places, the median over the joints
  double jerk = 0;                ///< m/s^3, of joints' places without that noise, the median over the joints
};
/// White noise of joints' places (T, J, 3), metres, on any skeleton: the median over the joints.
/// @param rate frames a second
double noise_of_places(const torch::Tensor& joints, double rate);

/// Noise and jerk of a motion.
/// @param rate frames a second
Levels levels_of(const Bones& bones, const Trajectory& trajectory, double rate);

}  // namespace inhabit::refine
