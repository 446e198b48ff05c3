#pragma once
#include <Eigen/Core>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// The plane that a person's feet stand on.
struct FloorSlope {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit, in the world of the recording
  double degrees = 0;                                 ///< between normal and +Y
  double uncertainty = 0;  ///< degrees, one standard deviation in the direction that is known least
  double off_plane = 0;    ///< metres, mean distance of the standing feet from the plane,
  double off_level = 0;    ///< and from the level plane in their midst
  int64_t stances = 0;     ///< feet that stand, a second at most each; fewer than kLeastStances: nothing is known

  static constexpr int64_t kLeastStances = 4;  ///< that tell a slope
  /// Whether the recording itself slopes: by more than a degree and twice the uncertainty.
  bool certain() const { return stances >= kLeastStances && degrees > 1 && degrees > 2 * uncertainty; }
};

/// Finds it from the balls of the feet (ankles where the skeleton has none) while they are slow, of which most stand on
/// one plane: feet that somebody who sits holds up are outliers. Across the way the person faces, where feet are close
/// together, the lines between hips and between shoulders tell too: on average they are level. Slopes up to 20 degrees
/// are looked for; in a direction of which nothing is known it is 0. On a skeleton that find_landmarks does not know
/// nothing is.
FloorSlope floor_slope(const Clip& clip);

/// Rotates a clip about the origin, `rotation` (3, 3) float32, with all that is annotated.
void rotate_clip(Clip& clip, const torch::Tensor& rotation);

/// (3, 3) float32: the shortest rotation that takes a direction to +Y.
torch::Tensor rotation_upright(const Eigen::Vector3d& up);

/// Rotates a clip so that its floor is level.
void level(Clip& clip, const FloorSlope& slope);

}  // namespace inhabit
