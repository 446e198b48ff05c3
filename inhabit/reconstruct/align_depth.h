#pragma once
#include <Eigen/Core>
#include <vector>

#include "inhabit/reconstruct/depth_map.h"

namespace inhabit::reconstruct {

/// What one frame says about the depth's scale.
struct SeenBody {
  std::vector<DepthSample> person;        ///< raw depth of the person's pixels
  std::vector<Eigen::Vector3d> vertices;  ///< of the body, as estimated, that the camera sees; in its axes, metres
  /// (vertices) raw depth where each is seen; NaN where that is none of the person's.
  std::vector<double> raw;
};

struct DepthAlignment {
  DepthScale scale;
  double before = 0,
         after = 0;   ///< metres, median distance between points and vertices: by the first guess, at the end
  double spread = 0;  ///< metres, standard deviation of the body's depth: what tells scale from offset
};

/// Scale s and offset o of D = s raw + o, the same for all frames, for which the person's points P lie on the visible
/// vertices V: least sum over frames of the Chamfer distance d(V, P) (supplement 8.1),
///   mean over p of rho(|p - V|) + mean over v of rho(|v - P|),
/// rho Huber's loss. Begun at a robust line through the depths of vertices over the raw depths at their pixels, then
/// nearest places are found and s, o solved for in turns. Throws Error(subject, ...) where no frame has a person, or
/// raw depth falls as bodies are farther away (disparity).
DepthAlignment align_depth(const std::vector<SeenBody>& frames, const std::string& subject);

}  // namespace inhabit::reconstruct
