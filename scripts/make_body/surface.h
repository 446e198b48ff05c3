#pragma once
#include <Eigen/Geometry>

namespace inhabit {

/// Approximate signed distance, metres, from `point` (pelvis frame, rest pose) to the skin of the built-in body;
/// negative inside. Mirror symmetric in the plane x = 0. Elliptic sections lofted along trunk and limbs, joined by
/// smooth unions; widths and depths follow mean adult breadths for the stature of proportions.h.
double builtin_surface_distance(const Eigen::Vector3d& point);

}  // namespace inhabit
