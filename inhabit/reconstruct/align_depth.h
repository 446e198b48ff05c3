#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "inhabit/reconstruct/depth_map.h"

namespace inhabit::reconstruct {

/// What one frame says about the depth's scale.
struct SeenBody {
  std::vector<DepthSample> person;        ///< raw depth of the person's pixels
  std::vector<Eigen::Vector3d> vertices;  ///< of the body, as estimated, that the camera sees; in its axes, metres
  /// (vertices) raw depth where each is seen; NaN where that is none of the person's.
  std::vector<double> raw;
  /// Pixels that would be the floor's if nothing stood on it: raw depth, and the depth of the floor that the body
  /// stands on, metres along the camera's axis.
  std::vector<std::array<double, 2>> floor;
};

/// The scale of a recording's depth, and how well it is known.
struct DepthAlignment {
  DepthScale scale;   ///< of all frames
  double before = 0;  ///< metres, median distance from the person's points to the nearest vertices, by the first guess
  double after = 0;   ///< metres, the same at the end
  double floor = 0;   ///< part of the pixels below the horizon that are the floor; 0: it tells nothing
  double spread = 0;  ///< metres, standard deviation of the body's depth: what tells scale from offset
};

/// Scale s and offset o of D = s raw + o, the same for all frames, for which the person's points P lie on the visible
/// vertices V: least sum over frames of the Chamfer distance d(V, P) (supplement 8.1),
///   mean over p of rho(|p - V|) + mean over v of rho(|v - P|),
/// rho Huber's loss. Beyond the paper, where the floor is seen each frame's mean over its pixels of rho(s raw + o - D)
/// counts as well, D the depth of the plane under the body's feet: a body alone tells s only by how much it comes
/// nearer and goes away. The floor is seen where a tenth of the pixels below the horizon lie on such a plane for one s
/// that agrees with the body, and their depths differ. Begun at a robust line through the depths of vertices over the
/// raw depths at their pixels, then nearest places are found and s, o solved for in turns. Throws Error(subject, ...)
/// where no frame has a person, or raw depth falls as bodies are farther away (disparity).
DepthAlignment align_depth(const std::vector<SeenBody>& frames, const std::string& subject);

}  // namespace inhabit::reconstruct
