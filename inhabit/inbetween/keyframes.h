#pragma once
#include <torch/types.h>

#include <cstdint>
#include <string>
#include <vector>

#include "inhabit/body/skeleton.h"
#include "inhabit/inbetween/config.h"
#include "inhabit/motion/clip.h"

namespace inhabit::inbetween {

/// The key frames of a clip, in order, each once; the first and the last frame are always among them. `text` is one of
///   every:N        frames 0, N, 2N, ...
///   0,30,95        these frames
///   random:P       each frame with probability P in (0, 1], drawn from `seed`
///   ends           the first and the last alone
/// Throws Error("NAME TEXT", ...) for anything else, a frame outside the clip, or a clip of fewer than two frames.
std::vector<int64_t> key_frames(const std::string& text, int64_t frames, uint64_t seed = 0,
                                const std::string& name = "key frames");

/// The frames of a list such as 40,0,95, in its order. Throws Error("NAME TEXT", ...) where it is none, or a frame is
/// outside the clip.
std::vector<int64_t> listed_frames(const std::string& text, int64_t frames, const std::string& name = "key frames");

/// Key poses at given times as a clip; frames between them repeat the pose before.
struct PosesInTime {
  Clip clip;                  ///< on the poses' skeleton, or the standard one where they have several or no rotations
  std::vector<int64_t> keys;  ///< its frames that are poses
  bool standard = false;      ///< the clip is on the standard skeleton because the poses share none
};

/// The clip has the highest rate of the poses, at which their times are rounded to frames.
/// @param poses clips on any skeleton, whose first frames count. @param seconds the time of each, in order. @param rate
/// frames a second of poses that have less than 12: a pose by itself needs none. @param names what errors call them.
/// Throws Error where times are not a frame apart, more than 55 minutes apart or not one for each pose, or a pose is of
/// a person with other bones than the first's (2 cm).
PosesInTime poses_at_times(const std::vector<Clip>& poses, const std::vector<double>& seconds, double rate,
                           const std::vector<std::string>& names);

/// The same of frames of one clip, in the order of `frames`, which stand at other times than the clip has them.
/// @param name what errors call the clip
PosesInTime frames_at_times(const Clip& clip, const std::vector<int64_t>& frames, const std::vector<double>& seconds,
                            const std::string& name);

/// Groups of a frame's features; a partial key constrains a group as a whole or not at all: root translation, root
/// orientation, body rotations, then the position of each standard joint.
inline constexpr int64_t kRootTranslationGroup = 0,  ///< features [0, 3)
    kRootOrientationGroup = 1,                       ///< features [3, 9)
    kBodyRotationsGroup = 2,                         ///< features [9, 135)
    kJointGroups = 3,                                ///< the first joint's, of one a joint
    kKeyGroups = kMaskChannels;                      ///< how many there are
static_assert(kKeyGroups == kJointGroups + kStandardJoints);

/// (25) float: 1 for the groups that `joints` constrain. "pelvis,left_wrist": the positions of these joints; the pelvis
/// includes the root translation, which is the same point. "root" is another name of the pelvis. An empty text: whole
/// poses. Throws Error("--joints TEXT", ...) for a name that is no standard joint's.
torch::Tensor key_groups(const std::string& joints, const Skeleton& file = {});

/// The joints whose positions groups (25) constrain, standard order; none where `groups` is undefined (whole poses).
std::vector<int64_t> key_joints_of(const torch::Tensor& groups);

/// (..., kFeatureCount) from groups (..., 25): each feature takes its group's value.
torch::Tensor feature_mask(const torch::Tensor& groups);

}  // namespace inhabit::inbetween
