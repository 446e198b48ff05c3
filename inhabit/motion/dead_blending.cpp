#include "inhabit/motion/dead_blending.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/smooth_step.h"

namespace inhabit {
namespace {

constexpr double kStays = 0.794;  // of the velocity from frame to frame: half of it after 3

}  // namespace

void dead_blend(PoseTrack& track, const PoseTrack& before, int64_t frames) {
  const int64_t last = before.frames() - 1;
  const Eigen::Vector3d step = track.trans[0] - before.trans[static_cast<size_t>(last)];
  std::vector<Eigen::Quaterniond> turn;
  turn.reserve(static_cast<size_t>(track.joints));
  for (int j = 0; j < track.joints; ++j) turn.push_back(before.at(last, j).conjugate() * track.at(0, j));
  double carried = 0;  // frames at the first velocity
  for (int64_t t = 1; t <= std::min(frames, track.frames() - 1); ++t) {
    carried += std::pow(kStays, static_cast<double>(t - 1));
    const double faded = smooth_step(static_cast<double>(t) / static_cast<double>(frames + 1));
    Eigen::Vector3d& trans = track.trans[static_cast<size_t>(t)];
    trans = (1 - faded) * (track.trans[0] + carried * step) + faded * trans;
    for (int j = 0; j < track.joints; ++j) {
      const Eigen::Quaterniond on =
          track.at(0, j) * Eigen::Quaterniond::Identity().slerp(carried, turn[static_cast<size_t>(j)]);
      track.at(t, j) = on.slerp(faded, track.at(t, j)).normalized();
    }
  }
}

}  // namespace inhabit
