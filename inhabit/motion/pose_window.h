#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// The last seconds of one person's joints as they come in: at any times, now and then not at all, some joints unseen.
/// Memory is taken once and does not grow. Poses that come faster than 240 a second take the place of the one before.
class PoseWindow {
 public:
  /// @param skeleton of the joints that are pushed; its offsets say where a joint lies from its parent, in somebody who
  /// faces +Z, until it is first seen (zero: that is not known)
  /// @param seconds that are kept at least @param longest_gap seconds without a pose after which it begins anew
  PoseWindow(const Skeleton& skeleton, double seconds, double longest_gap);

  /// A pose at `time` seconds: (J, 3) metres; a row with a value that is not finite is a joint that was not seen. A
  /// root that was not seen is put between the hips. Begins anew after a gap, and where time goes back by more than
  /// what is kept (a clock that was set). Throws Error, and takes nothing, where the time is not after the one before,
  /// a joint is over 10 km from the origin, or neither root nor both hips were seen.
  void push(double time, const torch::Tensor& joints);

  double first() const { return at(0).time; }          ///< seconds, of the poses that are kept; there must be one
  double last() const { return at(count_ - 1).time; }  ///< seconds
  /// From the first pose kept to the last; 0 without any.
  double seconds() const { return count_ == 0 ? 0 : last() - first(); }
  /// Whether no pose is kept.
  bool empty() const { return count_ == 0; }

  /// At most `frames` poses at `rate` a second of which the last is the last one pushed: joints alone, on the skeleton.
  /// Between two times at which a joint was seen it goes along a cubic (as resample() does where times are even), and
  /// straight over gaps of more than a quarter of a second. Before and after, it stays where it was from its parent,
  /// rotated with the person. Throws Error where a joint was never seen and the skeleton's offsets do not place it.
  Clip clip(double rate, int64_t frames) const;

 private:
  struct Pose {
    double time = 0;
    std::vector<Eigen::Vector3f> joints;
  };
  const Pose& at(size_t i) const { return ring_[(begin_ + i) % ring_.size()]; }
  Pose& at(size_t i) { return ring_[(begin_ + i) % ring_.size()]; }
  void remember(const Pose& pose);

  Skeleton skeleton_;
  std::vector<std::array<int, 2>> pairs_;  // joints of the left and the right from which the heading is told
  std::array<int, 2> hips_{-1, -1};
  double kept_, longest_gap_;
  std::vector<Pose> ring_;
  size_t begin_ = 0, count_ = 0;
  // What is known of joints that are not seen: places from their parents in the frame of the heading.
  double heading_ = 0;
  std::vector<Eigen::Vector3f> from_parent_;
  Eigen::Vector3f root_from_hips_ = Eigen::Vector3f::Zero();
};

}  // namespace inhabit
