#include "inhabit/inbetween/key_smoother.h"

#include <utility>

#include "inhabit/body/skeleton.h"
#include "inhabit/error.h"
#include "inhabit/inbetween/interpolate.h"
#include "inhabit/math/quaternion.h"

namespace inhabit::inbetween {

using Eigen::MatrixXd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

constexpr double kExactNoise = 1e-6;  // standard deviation of an exact key, in the values' own unit
constexpr int kIterations = 3;        // of Gauss-Newton; keys are off by degrees
// How lively people are, standard deviations of acceleration: those with which the smoother comes nearest to the truth
// on validation recordings, keys every 3 and every 15 frames, noise 1 (docs/inbetweening.md).
constexpr double kRootAcceleration = 3;    // m/s^2
constexpr double kJointAcceleration = 10;  // rad/s^2

}  // namespace

KeySmoother::KeySmoother(int64_t frames, std::vector<int64_t> keys, const std::vector<char>& exact, double noise,
                         double acceleration, double rate)
    : frames_(frames), keys_(std::move(keys)) {
  const double per_frame = acceleration / (rate * rate);  // of a second difference
  acceleration_weight_ = 1 / (per_frame * per_frame);
  std::vector<Eigen::Triplet<double>> entries;
  for (size_t k = 0; k < keys_.size(); ++k) {
    const double sigma = exact[k] != 0 ? kExactNoise : std::max(noise, kExactNoise);
    key_weights_.push_back(1 / (sigma * sigma));
    entries.emplace_back(keys_[k], keys_[k], key_weights_.back());
  }
  constexpr double kDifference[] = {1, -2, 1};
  for (int64_t t = 1; t + 1 < frames; ++t)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        entries.emplace_back(t + i - 1, t + j - 1, acceleration_weight_ * kDifference[i] * kDifference[j]);
  Eigen::SparseMatrix<double> normal(frames, frames);
  normal.setFromTriplets(entries.begin(), entries.end());
  system_.compute(normal);
  if (system_.info() != Eigen::Success) throw Error("keys", "are too few to be smoothed");
}

MatrixXd KeySmoother::solved(const MatrixXd& second_differences, const MatrixXd& missed) const {
  MatrixXd right = MatrixXd::Zero(frames_, missed.cols());
  for (size_t k = 0; k < keys_.size(); ++k) right.row(keys_[k]) = key_weights_[k] * missed.row(keys_[k]);
  for (int64_t t = 1; t + 1 < frames_; ++t) {
    const Eigen::RowVectorXd pull = acceleration_weight_ * second_differences.row(t);
    right.row(t - 1) -= pull;
    right.row(t) += 2 * pull;
    right.row(t + 1) -= pull;
  }
  return system_.solve(right);
}

MatrixXd KeySmoother::places(const MatrixXd& values) const {
  return solved(MatrixXd::Zero(frames_, values.cols()), values);
}

std::vector<Quaterniond> KeySmoother::rotations(const std::vector<Quaterniond>& interpolated) const {
  std::vector<Quaterniond> out = interpolated;
  MatrixXd velocities(frames_, 3), accelerations = MatrixXd::Zero(frames_, 3), missed = MatrixXd::Zero(frames_, 3);
  for (int i = 0; i < kIterations; ++i) {
    for (int64_t t = 0; t + 1 < frames_; ++t)
      velocities.row(t) =
          axis_angle_of(out[static_cast<size_t>(t)].conjugate() * out[static_cast<size_t>(t) + 1]).transpose();
    for (int64_t t = 1; t + 1 < frames_; ++t) accelerations.row(t) = velocities.row(t) - velocities.row(t - 1);
    for (const int64_t key : keys_)
      missed.row(key) =
          axis_angle_of(out[static_cast<size_t>(key)].conjugate() * interpolated[static_cast<size_t>(key)]).transpose();
    const MatrixXd changes = solved(accelerations, missed);
    for (int64_t t = 0; t < frames_; ++t) {
      Quaterniond& q = out[static_cast<size_t>(t)];
      q = (q * quaternion_of(Vector3d(changes.row(t).transpose()))).normalized();
    }
  }
  return out;
}

Poses smooth_poses(const Poses& interpolated, const std::vector<int64_t>& keys, const std::vector<char>& exact,
                   double level, double rate) {
  const int64_t frames = interpolated.frames();
  const KeySmoother root(frames, keys, exact, level / 100, kRootAcceleration, rate),
      joints(frames, keys, exact, level * M_PI / 180, kJointAcceleration, rate);
  MatrixXd places(frames, 3);
  for (int64_t t = 0; t < frames; ++t) places.row(t) = interpolated.root(t).cast<double>();
  places = root.places(places);
  Poses out = interpolated;
  for (int64_t j = 0; j < kStandardJoints; ++j) {
    std::vector<Quaterniond> local_rotations;
    local_rotations.reserve(static_cast<size_t>(frames));
    for (int64_t t = 0; t < frames; ++t) local_rotations.push_back(local_rotation(interpolated, t, j).cast<double>());
    local_rotations = joints.rotations(local_rotations);
    const int parent = standard_parents()[static_cast<size_t>(j)];
    for (int64_t t = 0; t < frames; ++t) {
      const Eigen::Quaternionf local = local_rotations[static_cast<size_t>(t)].cast<float>();
      out.rotations[Poses::at(t, j)] = j == 0 ? local : (out.rotations[Poses::at(t, parent)] * local).normalized();
    }
  }
  for (int64_t t = 0; t < frames; ++t) {
    out.joints[Poses::at(t, 0)] = places.row(t).transpose().cast<float>();
    place_joints(out, t);
  }
  return out;
}

Clip smooth_keys(const Clip& clip, const std::vector<int64_t>& keys, double level) {
  const Clip interpolated = interpolate_linear(clip, keys);
  std::vector<char> exact(keys.size(), 0);
  exact.front() = exact.back() = 1;
  Clip out = clip_of(smooth_poses(poses_of(interpolated), keys, exact, level, clip.rate), interpolated);
  for (const int64_t end : {keys.front(), keys.back()})  // bit by bit
    for (torch::Tensor Clip::*part : {&Clip::trans, &Clip::rotations, &Clip::joints})
      (out.*part)[end].copy_((interpolated.*part)[end]);
  return out;
}

}  // namespace inhabit::inbetween
