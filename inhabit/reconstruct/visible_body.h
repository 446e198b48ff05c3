#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "inhabit/reconstruct/align_depth.h"
#include "inhabit/reconstruct/depth_map.h"
#include "inhabit/refine/depth_terms.h"
#include "inhabit/refine/trajectory.h"

namespace inhabit::reconstruct {

/// The skin of an estimated motion, frame by frame.
struct BodyInFrames {
  std::shared_ptr<const refine::Skin> skin;  ///< of the body, in the motion's shape where it tells one (shape_in)
  Bones bones;                               ///< the motion's skeleton, which need not be the body's
  refine::Trajectory poses;                  ///< (frames) in the world

  /// @param motion on the standard skeleton, in the world; @param body whose skin was seen
  BodyInFrames(const Clip& motion, const BodyModel& body);

  /// The skin in a frame, vertices in the world.
  refine::PosedSkin posed(int64_t frame) const;
};

/// Vertices of the skin that the camera sees in a frame: no other skin is before them, and they are where the mask
/// (height, width) bool says that the person is seen. Every `step`-th is looked at.
std::vector<int> visible_vertices(const BodyInFrames& body, const refine::PosedSkin& posed, const torch::Tensor& mask,
                                  const Camera& camera, int64_t frame, int step);

/// Height of the floor that the body stands on, metres: the median over frames of its lowest vertex, of every
/// `step`-th frame.
double feet_height(const BodyInFrames& body, int64_t step);

/// What the frame says about the scale of its depth. @param mask (height, width) bool: the person. @param floor metres,
/// height of the floor under the body
SeenBody seen_body(const BodyInFrames& body, const DepthMap& depth, const torch::Tensor& mask, const Camera& camera,
                   int64_t frame, double floor);

/// The same for the root's place: the person's points in the world from metric depth, and the vertices that belong to
/// them.
refine::DepthCloud seen_cloud(const BodyInFrames& body, const View& view, const Camera& camera);

}  // namespace inhabit::reconstruct
