#pragma once
#include "inhabit/motion/clip.h"
#include "inhabit/refine/problem.h"

namespace inhabit::refine {

/// The poses of a clip with rotations.
Trajectory trajectory_of(const Clip& clip);

/// `like` with the poses of `trajectory` and its joints by forward kinematics. Frames whose poses are those of `like`
/// keep the bits, and the joints, that it has.
Clip clip_of(const Trajectory& trajectory, const Clip& like);

using Poses = std::vector<BonesPose>;        ///< a frame each
using Track = std::vector<Eigen::Vector3d>;  ///< places of one point, a frame each, metres
/// Every joint's place and rotation in the world, frame by frame, by forward kinematics.
Poses posed(const Bones& bones, const Trajectory& trajectory);
/// The places of one joint, frame by frame, metres.
Track track_of(const Poses& poses, int joint);

}  // namespace inhabit::refine
