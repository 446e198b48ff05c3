#include "inhabit/motion/dead_blending.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "inhabit/math/smooth_step.h"

namespace inhabit {
namespace {

constexpr double kStays = 0.794;  // of the velocity from frame to frame: half of it after 3

}  // namespace

void dead_blend(PoseTrack& track, const PoseTrack& before, int64_t frames) {
  const int64_t last = before.frames() - 1;
  const Eigen::Vector3d step = track.trans[0] - before.trans[static_cast<size_t>(last)];
  PoseTrack on = track;  // the first motion carried on, as long as it counts
  std::vector<double> weights(track.trans.size(), 1);
  double steps = 0;  // at the first velocity
  for (int64_t t = 1; t <= std::min(frames, track.frames() - 1); ++t) {
    steps += std::pow(kStays, static_cast<double>(t - 1));
    weights[static_cast<size_t>(t)] = smooth_step(static_cast<double>(t) / static_cast<double>(frames + 1));
    on.trans[static_cast<size_t>(t)] = track.trans[0] + steps * step;
    for (int j = 0; j < track.joints; ++j) {
      const Eigen::Quaterniond turn = before.at(last, j).conjugate() * track.at(0, j);
      on.at(t, j) = track.at(0, j) * Eigen::Quaterniond::Identity().slerp(steps, turn);
    }
  }
  track = mixed(std::move(on), track, weights);
}

}  // namespace inhabit
