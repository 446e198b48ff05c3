#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "inhabit/motion/clip.h"

namespace inhabit::refine {

/// Where a joint, or a point that moves with it, is wanted.
struct JointTarget {
  int64_t frame = 0;                                          ///< of the motion
  int joint = 0;                                              ///< of the standard skeleton
  Eigen::Vector3d place;                                      ///< metres, world
  Eigen::Vector3d sigma = Eigen::Vector3d::Constant(0.0003);  ///< metres along each axis; infinite: left free
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();           ///< of the point, metres in the joint's frame
};

/// Targets where the joints of a pose are. @param pose row of `poses` that is `frame` of the motion
std::vector<JointTarget> joint_targets(const Clip& poses, int64_t pose, int64_t frame,
                                       const std::vector<int64_t>& joints);

/// What a network's motion was conditioned on.
struct KeyPoses {
  std::vector<int64_t> frames;       ///< of the motion, in order
  Clip poses;                        ///< (K) one for each, on the motion's skeleton
  std::vector<char> exact;           ///< (K) 1: a hard constraint, that frame comes out as the pose is, bit by bit
                                     ///< 0: a whole pose with noise
  std::vector<JointTarget> targets;  ///< of partial keys and contacts, in any order
};

/// Standard deviations of what a network's motion is changed by.
struct GeneratedOptions {
  double rotation = 0.2;      ///< radians of each joint
  double root = 0.6;          ///< metres of the root
  double rotation_curve = 1;  ///< rad/s^2 of each joint: changes come and go smoothly
  double root_curve = 2;      ///< m/s^2 of the root, the same
  double noise = 1;     ///< of whole keys that are not exact: degrees in each component of a rotation, centimetres
  bool smooth = false;  ///< the motion has the keys' noise: it is smoothed itself, in place of what it is changed by
};

/// A network's motion brought to the poses that it was conditioned on. Hard keys are met exactly and the frames around
/// change smoothly along with them; targets are met within millimetres, as far as limbs reach, by the least change of
/// the body but its orientation; noisy keys count by their noise.
/// @param motion on the standard skeleton with rotations. Throws Error where sizes disagree.
Clip refine_generated(const Clip& motion, const KeyPoses& keys, const GeneratedOptions& options = {});

}  // namespace inhabit::refine
