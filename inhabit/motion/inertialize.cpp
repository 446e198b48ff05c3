#include "inhabit/motion/inertialize.h"

#include <algorithm>

namespace inhabit {

void inertialize(PoseTrack& track, const PoseTrack& before, int64_t frames) {
  if (track.frames() < 2) return;
  const int64_t last = before.frames() - 1;
  const Eigen::Vector3d off = 2 * track.trans[0] - before.trans[static_cast<size_t>(last)] - track.trans[1];
  std::vector<Eigen::Quaterniond> turned;
  for (int j = 0; j < track.joints; ++j) {
    const Eigen::Quaterniond &now = track.at(0, j), &then = before.at(last, j);
    turned.push_back(track.at(1, j).conjugate() * now * then.conjugate() * now);
  }
  for (int64_t t = 1; t <= std::min(frames, track.frames() - 1); ++t) {
    const double u = static_cast<double>(t - 1) / static_cast<double>(frames), left = 1 - u * u * (3 - 2 * u);
    track.trans[static_cast<size_t>(t)] += left * off;
    for (int j = 0; j < track.joints; ++j) {
      Eigen::Quaterniond& q = track.at(t, j);
      q = (q * Eigen::Quaterniond::Identity().slerp(left, turned[static_cast<size_t>(j)])).normalized();
    }
  }
}

}  // namespace inhabit
