#pragma once
#include <Eigen/Geometry>
#include <vector>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// The rotations and the root of a clip in double precision, for code that works frame by frame.
struct PoseTrack {
  int joints = 0;                         ///< J
  std::vector<Eigen::Quaterniond> local;  ///< frame after frame, one unit quaternion a joint, relative to its parent
  std::vector<Eigen::Vector3d> trans;     ///< (T) metres, as Clip::trans
  std::vector<Eigen::Vector3d> places;    ///< as Clip::translations, laid out as `local`; empty: the bones are rigid

  /// T.
  int64_t frames() const { return static_cast<int64_t>(trans.size()); }
  /// Rotation of a joint in a frame, relative to its parent.
  Eigen::Quaterniond& at(int64_t frame, int joint) { return local[static_cast<size_t>(frame * joints + joint)]; }
  /// The same, to read.
  const Eigen::Quaterniond& at(int64_t frame, int joint) const {
    return local[static_cast<size_t>(frame * joints + joint)];
  }
};

/// Needs clip.rotations and clip.trans.
PoseTrack pose_track(const Clip& clip);

/// Sets rotations, trans, translations and, by forward kinematics on clip.skeleton, joints.
void set_pose(Clip& clip, const PoseTrack& track);

/// Replaces the frames between `from` and `to` by what lies between those two: the root linearly, rotations by slerp
/// over the shorter arc.
void interpolate_between(PoseTrack& track, int64_t from, int64_t to);

/// Poses of `a` and `b`, on one skeleton, mixed frame by frame: root and joints that translate linearly, rotations by
/// slerp. @param weights (T) of b, 0 to 1
Clip mixed(const Clip& a, const Clip& b, const std::vector<double>& weights);
/// The same of tracks.
PoseTrack mixed(PoseTrack a, const PoseTrack& b, const std::vector<double>& weights);

/// Global rotations (joint frame to world) of every frame, laid out as PoseTrack::local.
std::vector<Eigen::Quaterniond> global_rotations(const PoseTrack& track, const std::vector<int>& parents);

}  // namespace inhabit
