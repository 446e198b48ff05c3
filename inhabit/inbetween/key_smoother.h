#pragma once
#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <cstdint>
#include <vector>

#include "inhabit/inbetween/poses.h"
#include "inhabit/motion/clip.h"

namespace inhabit::inbetween {

/// What a Rauch-Tung-Striebel smoother of noisy key values gives, all frames in one banded system: the path with the
/// greatest probability where accelerations are normal and white, and keys are off by normal noise. One system serves
/// all numbers of a pose that are as noisy and as lively as each other.
class KeySmoother {
 public:
  /// @param frames T. @param keys in order, in [0, T). @param exact for each key whether it has no noise. @param noise
  /// standard deviation of the other keys' values. @param acceleration standard deviation of what is smoothed, per
  /// second squared. @param rate frames a second
  KeySmoother(int64_t frames, std::vector<int64_t> keys, const std::vector<char>& exact, double noise,
              double acceleration, double rate);

  /// (T, D); rows that are no keys are not looked at.
  Eigen::MatrixXd places(const Eigen::MatrixXd& values) const;
  /// Of rotations (T), which must change by much less than pi from one frame to the next, as an interpolation of the
  /// keys does. Gauss-Newton on the rotation vectors by which each frame is rotated.
  std::vector<Eigen::Quaterniond> rotations(const std::vector<Eigen::Quaterniond>& interpolated) const;

 private:
  Eigen::MatrixXd solved(const Eigen::MatrixXd& second_differences, const Eigen::MatrixXd& missed) const;

  int64_t frames_;
  std::vector<int64_t> keys_;
  std::vector<double> key_weights_;
  double acceleration_weight_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> system_;
};

/// Motion between noisy keys (with_noise), of the root and every joint's local rotation. @param interpolated linear and
/// slerp between the keys (T frames). @param exact for each key whether it has no noise
Poses smooth_poses(const Poses& interpolated, const std::vector<int64_t>& keys, const std::vector<char>& exact,
                   double level, double rate);

/// The same of a clip; the first key and the last are exact. Arguments and errors as of interpolate_linear.
Clip smooth_keys(const Clip& clip, const std::vector<int64_t>& keys, double level);

}  // namespace inhabit::inbetween
