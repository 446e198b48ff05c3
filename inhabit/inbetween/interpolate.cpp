#include "inhabit/inbetween/interpolate.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "inhabit/error.h"
#include "inhabit/motion/pose_track.h"

namespace inhabit::inbetween {
namespace {

void require_keys(const Clip& clip, const std::vector<int64_t>& keys) {
  if (keys.size() < 2) throw Error("key frames", "are fewer than two");
  for (size_t k = 1; k < keys.size(); ++k)
    if (keys[k] <= keys[k - 1]) throw Error("key frames", "are not in order");
  if (keys.front() != 0 || keys.back() != clip.frames() - 1)
    throw Error("key frames", "are not from the clip's first frame to its last");
}

/// The clip with another motion, and without what is known of the old one.
Clip moved(const Clip& clip, const PoseTrack& track) {
  Clip out = person_of(clip);
  set_pose(out, track);
  return out;
}

/// Second derivatives at the knots of the natural cubic splines through values (K, D) at times (K), by elimination of
/// the tridiagonal system.
Eigen::MatrixXd natural_curvature(const std::vector<int64_t>& times, const Eigen::MatrixXd& values) {
  const Eigen::Index K = values.rows();
  Eigen::MatrixXd curvature = Eigen::MatrixXd::Zero(K, values.cols());
  Eigen::VectorXd upper = Eigen::VectorXd::Zero(K);
  const auto gap = [&](Eigen::Index k) {
    return static_cast<double>(times[static_cast<size_t>(k) + 1] - times[static_cast<size_t>(k)]);
  };
  for (Eigen::Index k = 1; k + 1 < K; ++k) {
    const double before = gap(k - 1), after = gap(k);
    const Eigen::RowVectorXd bend =
        6 * ((values.row(k + 1) - values.row(k)) / after - (values.row(k) - values.row(k - 1)) / before);
    const double pivot = 2 * (before + after) - before * upper[k - 1];
    upper[k] = after / pivot;
    curvature.row(k) = (bend - before * curvature.row(k - 1)) / pivot;
  }
  for (Eigen::Index k = K - 2; k > 0; --k) curvature.row(k) -= upper[k] * curvature.row(k + 1);
  return curvature;
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
  const Eigen::MatrixXd curvature = natural_curvature(keys, values);
  for (Eigen::Index k = 0; k + 1 < K; ++k) {
    const int64_t from = keys[static_cast<size_t>(k)], to = keys[static_cast<size_t>(k) + 1];
    const auto gap = static_cast<double>(to - from);
    for (int64_t t = from + 1; t < to; ++t) {
      const double u = static_cast<double>(t - from) / gap, v = 1 - u;
      const Eigen::RowVectorXd row =
          v * values.row(k) + u * values.row(k + 1) +
          gap * gap / 6 * ((v * v * v - v) * curvature.row(k) + (u * u * u - u) * curvature.row(k + 1));
      track.trans[static_cast<size_t>(t)] = row.head(3).transpose();
      for (int j = 0; j < track.joints; ++j) {
        const Eigen::Vector4d q = row.segment(3 + 4 * j, 4).transpose();
        track.at(t, j) = Eigen::Quaterniond(q).normalized();
      }
    }
  }
  return moved(clip, track);
}

}  // namespace inhabit::inbetween
