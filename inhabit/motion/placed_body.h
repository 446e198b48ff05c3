#pragma once
#include <vector>

#include "inhabit/body/body_model.h"
#include "inhabit/motion/clip.h"

namespace inhabit {

// A body in the poses of a clip, as the points that a scene is asked about. Metres, world. The body has the clip's
// betas; skin and anchors stand with their root joint at the clip's, so that a person whose bones differ from the
// body's own stays in place. All need clip.rotations.

/// The skin's vertices (T, V, 3).
torch::Tensor skin_points(const Clip& clip, const BodyModel& body);

/// The body's anchors (T, A, 3), skin vertices that stand for all of it (BodyModel::anchors).
torch::Tensor anchor_points(const Clip& clip, const BodyModel& body);

/// Points along the axes of a body's capsules, carried by the clip's own skeleton.
struct CapsulePoints {
  torch::Tensor points;        ///< (T, N, 3)
  std::vector<int64_t> first;  ///< of each capsule among the N, and one past the last
  std::vector<float> radii;    ///< of each capsule
  std::vector<int> joints;     ///< that moves each capsule
};
/// @param spacing metres between neighbours on an axis, at most. Needs clip.trans too.
CapsulePoints capsule_points(const Clip& clip, const BodyModel& body, double spacing);

}  // namespace inhabit
