#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "inhabit/motion/clip.h"

namespace inhabit::inbetween {

// What an animator gives beside the key poses. Seconds count from the first key; metres, world, +Y up.

/// A joint, or the palm of a hand, at one place for a while.
struct JointContact {
  int joint = 0;                                     ///< of the standard skeleton
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< of what touches, metres in the joint's frame
  double from = 0;                                   ///< seconds, at which it begins
  double to = 0;                                     ///< seconds, at which it ends, this frame included
  Eigen::Vector3d place = Eigen::Vector3d::Zero();   ///< metres
};

/// The contact of a joint by its standard name or the one it has in a file's skeleton (standard_joint_called), or of
/// the palm of "left_hand" or "right_hand". Throws Error that lists the names where `name` is none of these.
JointContact joint_contact(const std::string& name, double from, double to, const Eigen::Vector3d& place,
                           const Skeleton& file = {});

/// How far what touches is from its place at most while each contact lasts, metres: over a centimetre or two where it
/// cannot be reached. @param motion on the standard skeleton, from the first key on
std::vector<double> contact_gaps(const std::vector<JointContact>& contacts, const Clip& motion);

/// Where the root is above the floor at a time.
struct PathPoint {
  double seconds = 0;                               ///< from the first key, between it and the last
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< x, z
};

/// What constrains a motion beside its key poses; nothing where all of it is empty.
struct Controls {
  /// One for each key in [0, 1], of those between the ends. Under 1 the pose is mixed, with that weight, into what
  /// would be there without these keys. Empty: all 1.
  std::vector<double> key_weights;
  std::vector<JointContact> contacts;  ///< in any order; models of residual motion alone take them
  /// In order. Between the two keys around each point the root goes along a curve through them and the points.
  std::vector<PathPoint> root_path;
  /// The last pose is the first again, where the last root is and facing as that does, and what follows on the last
  /// frame is what follows on the first: the clip can be repeated, in place or going on.
  bool loop = false;
};

/// Throws Error where weights are not one a key in [0, 1], or a time is outside of the clip's or out of order.
/// @param keys how many; @param seconds from the first to the last
void check(const Controls& controls, size_t keys, double seconds);

/// The root's curve over the floor (T, 3): x, z metres, and 1 in frames between two keys with a path point between
/// them, else 0: natural cubic splines in time from key to key, through the points. @param roots (T, 3) read in frames
/// `keys`. @param rate frames a second
torch::Tensor path_curve(const std::vector<PathPoint>& path, const torch::Tensor& roots,
                         const std::vector<int64_t>& keys, double rate);

/// The clip with its first pose as the last, moved to the last root's place over the floor and rotated to its heading.
/// @param standard the same clip on the standard skeleton
Clip with_looped_end(const Clip& clip, const Clip& standard);

}  // namespace inhabit::inbetween
