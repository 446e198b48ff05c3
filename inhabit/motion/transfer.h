#pragma once
#include <cstdint>
#include <vector>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// Poses that a motion on the standard skeleton was made from (key poses, the last observed one, or every frame of a
/// recording that was refined), on the skeleton of their file and on the standard one.
struct SourcePoses {
  Clip source;    ///< K poses on the file's skeleton; its rate is that of the result
  Clip standard;  ///< the same K poses on the standard skeleton, their rotations found as the motion's were
  std::vector<int64_t> frames;  ///< (K) frames of the result where they stand, rising; -1: just before it
  std::vector<double> at;       ///< (K) the same as frames of the motion
  std::vector<bool> exact;      ///< (K) poses that come out as they went in, bit by bit; empty: all
};

/// Poses of a recording, frames `keys` of it, rising, of which `kept` stand at frames `at` of a motion made from them;
/// those between two kept ones stand between these. @param standard the recording on the standard skeleton.
SourcePoses poses_of(const Clip& source, const Clip& standard, const std::vector<int64_t>& keys,
                     const std::vector<int64_t>& kept, const std::vector<int64_t>& at);

/// One pose after the other, of clips of one frame on one skeleton. Undefined where skeletons differ in names or
/// parents, or one has no rotations: an empty clip.
Clip joined_poses(const std::vector<Clip>& poses);

/// A motion of the standard skeleton on the skeleton that its poses came from: `count` frames at poses.source.rate.
///
/// The joint that stands for a standard one (find_landmarks) has the global rotation G(t) = S(t) A(t): S that of the
/// standard joint, A = S_k^-1 G_k at pose k and slerp between poses. Joints of the spine and the neck between two such
/// follow a slerp between theirs. All others (fingers, face, twist joints) are interpolated between the poses,
/// relative to their parents, as are translations. The pelvis goes where the standard one goes; then elbows and
/// shoulders, knees and hips rotate by the least that brings wrists and ankles to where the standard ones are; feet are
/// pointed from the standard ankles to the standard balls, and it is the balls that are met. Time runs evenly from pose
/// to pose, so that poses that stand between two frames of the motion are met at their own time.
///
/// Where the file has no rotations (joint positions only) it is the motion itself at that rate.
/// Throws Error where skeleton, poses and times do not agree.
Clip on_source_skeleton(const Clip& motion, const SourcePoses& poses, int64_t count);

/// What follows on frame `start` - 1 of `source`, on its skeleton and at its rate. @param last that frame on the
/// standard skeleton, its rotations found as those of `future` were; the first frame of `future` is 1 / future.rate
/// seconds later.
Clip going_on(const Clip& source, int64_t start, const Clip& last, const Clip& future);

/// Labels (..., T) of what going_on was given, for the frames that it gives.
torch::Tensor labels_going_on(const torch::Tensor& labels, double rate, double source_rate);

}  // namespace inhabit
