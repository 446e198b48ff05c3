#pragma once
#include <Eigen/Geometry>
#include <random>
#include <vector>

#include "inhabit/body/skeleton.h"
#include "inhabit/motion/clip.h"

namespace inhabit::inbetween {

/// Motion on the standard skeleton as plain numbers: T frames of 22 joints, frame by frame. Metres, world, +Y up.
struct Poses {
  std::vector<Eigen::Vector3f> offsets;       ///< (22) rest position relative to the parent, in the parent's frame
  std::vector<Eigen::Vector3f> joints;        ///< (T x 22) positions
  std::vector<Eigen::Quaternionf> rotations;  ///< (T x 22) joint frame to world

  /// T, which the number of joints tells.
  int frames() const { return static_cast<int>(joints.size()) / kStandardJoints; }
  /// Where a joint of a frame is in `joints` and `rotations`.
  static size_t at(int64_t frame, int64_t joint) { return static_cast<size_t>(frame * kStandardJoints + joint); }
  /// Place of the root joint in a frame.
  const Eigen::Vector3f& root(int64_t frame) const { return joints[at(frame, 0)]; }
};

/// Of a clip with rotations on the standard skeleton; joints by forward kinematics. @param floor metres, which becomes
/// height 0.
Poses poses_of(const Clip& clip, double floor = 0);

/// The clip of these poses, of the person of `like`, whose skeleton has these offsets. @param floor metres, which
/// height 0 becomes
Clip clip_of(const Poses& poses, const Clip& like, double floor = 0);

/// Frames [first, first + frames), mirrored left to right (x becomes -x, joints change sides) where `mirrored` is set.
Poses window_of(const Poses& poses, int64_t first, int64_t frames, bool mirrored = false);

/// `frames` frames of the same motion at another pace: frame t is what `poses` has at t x pace, between frames by
/// cubics of the root and of quaternions, which keep what is quick (slerp would smooth it). @param pace such that
/// (frames - 1) x pace is no later than the last frame
Poses at_pace(const Poses& poses, int64_t frames, double pace);

/// Relative to the parent, of the root in the world.
Eigen::Quaternionf local_rotation(const Poses& poses, int64_t frame, int64_t joint);

/// Every frame with normal noise of `level` degrees on each component of the local rotations and `level` cm on each of
/// the root's position.
Poses with_noise(const Poses& poses, double level, std::mt19937_64& random);

/// The level of with_noise that moves joints by as much as what is quicker in a clip than motion is (refine/noise.h).
/// Noise that stays for several frames, as in estimates from video, is not seen.
double measured_noise(const Clip& clip);

/// Puts a frame of `from` into the same frame of `to`.
void copy_frame(const Poses& from, int64_t frame, Poses& to);

/// Joints of `frame` from its root position, its rotations and the offsets.
void place_joints(Poses& poses, int64_t frame);

/// Heading of a frame in radians, from the lines between hips and between shoulders: 0 is +Z, pi/2 is +X. `otherwise`
/// where these are vertical.
float heading_of(const Poses& poses, int64_t frame, float otherwise);

}  // namespace inhabit::inbetween
