#pragma once
#include <cstdint>
#include <vector>

#include "inhabit/motion/clip.h"
#include "inhabit/scene/query.h"

namespace inhabit::inbetween {

/// An interpolation of a clip's keys (interpolate_linear or interpolate_spline) moved onto the paths around obstacles
/// that A* finds (obstacle_detours.h), by the same search as a network's baseline by Detours::searched: between two
/// keys whose straight line is blocked the root follows the path at even speed over the ground, and rotates with it, by
/// the angle from the straight line to the path, less within half a second of the keys. Everything else stays. On the
/// standard skeleton.
/// @param clip read in frames `keys` only. Where there is no path, or none that can be walked in the time, nothing
/// changes.
Clip move_around_obstacles(const Clip& interpolated, const Clip& clip, const std::vector<int64_t>& keys,
                           const SceneQuery& scene);

}  // namespace inhabit::inbetween
