#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>

#include "inhabit/body/body_model.h"
#include "inhabit/io/cloud_sequence.h"
#include "inhabit/motion/clip.h"

namespace inhabit::refine {

/// How a motion is fitted to point clouds.
struct DepthOptions {
  /// The body whose skin was seen, in the clip's own shape where the clip is of that model; null: the built-in one.
  const BodyModel* body = nullptr;
  /// Where the depth camera stands, metres, in the clip's world. With it the Chamfer distance has both sides.
  std::optional<Eigen::Vector3d> camera;
  double smooth = 1;            ///< factor on both smoothness priors
  int64_t window = 120;         ///< frames solved at once, P in the paper
  int64_t points = 400;         ///< of each cloud that are pulled to the skin, evenly taken
  std::string name = "motion";  ///< what errors call the clip
  bool standard = false;        ///< the motion is wanted on the standard skeleton alone
};

/// The motion that fits the point clouds, and how well it does.
struct DepthResult {
  Clip before;                 ///< the motion as it was, on the standard skeleton
  Clip clip;                   ///< on the standard skeleton, at the motion's own rate
  Clip on_source;              ///< the same on the clip's own skeleton; empty where DepthOptions::standard is set
  double distance_before = 0;  ///< metres, from the points to the skin of `before`, median of the frames' medians
  double distance_after = 0;   ///< metres, the same of `clip`
  double moved = 0;            ///< metres, mean distance of the joints from where they were
};

/// A motion that fits what a depth camera saw of the person, window by window in two stages (forecasting paper,
/// appendix A.1.2, Eq. 14 to 20): the root's translation and rotation, then all other joints. docs/refinement.md says
/// what differs from the paper.
/// @param clip on any skeleton that maps to the standard one (retarget); what fingers and face do is not used.
/// @param clouds one a frame of the clip, in its world. Each is read once, when its window is reached, and dropped
/// after. Throws Error for what cannot be retargeted, another number of clouds than frames, and clouds that are not
/// where the body is: other units or axes.
DepthResult refine_to_depth(const Clip& clip, const CloudSequence& clouds, const DepthOptions& options = {});

}  // namespace inhabit::refine
