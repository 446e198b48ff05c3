#include "inhabit/inbetween/interpolate.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "inhabit/error.h"
#include "inhabit/math/natural_spline.h"
#include "inhabit/motion/pose_track.h"

namespace inhabit::inbetween {
namespace {

void require_keys(const Clip& clip, const std::vector<int64_t>& keys) {
  if (keys.size() < 2) throw Error("keys", "are fewer than two");
  for (size_t k = 1; k < keys.size(); ++k)
    if (keys[k] <= keys[k - 1]) throw Error("keys", "are not in order");
  if (keys.front() != 0 || keys.back() != clip.frames() - 1)
    throw Error("keys", "are not from the clip's first frame to its last");
}

/// The clip with another motion, and without what is known of the old one.
Clip moved(const Clip& clip, const PoseTrack& track) {
  Clip out = person_of(clip);
  set_pose(out, track);
  return out;
}

}  // namespace

Clip interpolate_linear(const Clip& clip, const std::vector<int64_t>& keys) {
  require_keys(clip, keys);
  PoseTrack track = pose_track(clip);
  for (size_t k = 0; k + 1 < keys.size(); ++k) interpolate_between(track, keys[k], keys[k + 1]);
  return moved(clip, track);
}

Clip interpolate_spline(const Clip& clip, const std::vector<int64_t>& keys) {
  require_keys(clip, keys);
  PoseTrack track = pose_track(clip);
  const auto K = static_cast<Eigen::Index>(keys.size());
  Eigen::MatrixXd values(K, 3 + 4 * track.joints);  // root, then x y z w of each joint
  for (Eigen::Index k = 0; k < K; ++k) {
    const int64_t t = keys[static_cast<size_t>(k)];
    values.row(k).head(3) = track.trans[static_cast<size_t>(t)].transpose();
    for (int j = 0; j < track.joints; ++j) {
      Eigen::RowVector4d q = track.at(t, j).coeffs().transpose();
      if (k > 0 && q.dot(values.row(k - 1).segment(3 + 4 * j, 4)) < 0) q = -q;
      values.row(k).segment(3 + 4 * j, 4) = q;
    }
  }
  const NaturalSpline spline({keys.begin(), keys.end()}, values);
  for (size_t k = 0; k + 1 < keys.size(); ++k)
    for (int64_t t = keys[k] + 1; t < keys[k + 1]; ++t) {
      const Eigen::RowVectorXd row = spline.at(static_cast<double>(t));
      track.trans[static_cast<size_t>(t)] = row.head(3).transpose();
      for (int j = 0; j < track.joints; ++j) {
        const Eigen::Vector4d q = row.segment(3 + 4 * j, 4).transpose();
        track.at(t, j) = Eigen::Quaterniond(q).normalized();
      }
    }
  return moved(clip, track);
}

}  // namespace inhabit::inbetween
