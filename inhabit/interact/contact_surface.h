#pragma once
#include "inhabit/interact/chair.h"
#include "inhabit/scene/query.h"

namespace inhabit::interact {

/// Metres from a chair's surface within which a place is a contact of it (appendix 3).
inline constexpr double kOffSurface = 0.1;

/// Moves a contact of a hand (0 left, 1 right) to the surface of what is sat on. Throws Error where it is over
/// kOffSurface from it, or out of the arm's reach of somebody who sits upright and may lean.
/// @param surface of the chair alone. @param force contacts out of reach are taken too.
Eigen::Vector3d contact_on_surface(const Chair& chair, const SceneQuery& surface, const Skeleton& person, int hand,
                                   const Eigen::Vector3d& point, bool force = false);

}  // namespace inhabit::interact
