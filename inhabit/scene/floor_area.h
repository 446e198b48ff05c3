#pragma once
#include "inhabit/scene/free_space.h"

namespace inhabit {

/// Where somebody at `place` (x, z) can go on a scene's floor y = 0: free_space of `obstacles`, with the end of the
/// floor as one more, so that clearances are at most the distance to it, and negative beyond. Floor is what the scene
/// has within 10 cm of y = 0 and 50 m of the place; gaps under 1 m are holes of a scan, or furniture that hides it, and
/// belong to it. Without floor at the place nothing but the obstacles counts.
FreeSpace free_floor(const Scene& scene, const Scene& obstacles, const Eigen::Vector2d& place);

}  // namespace inhabit
