#pragma once
#include "inhabit/motion/clip.h"
#include "inhabit/scene/query.h"

namespace inhabit {

/// Height of what a person's feet stand on in a scene, metres: the median of the surfaces (or points of a cloud)
/// straight below the balls of the feet (standard joints) that are near to the floor under the poses (motion/floor.h).
/// Where the scene has nothing there, it is the floor under the poses.
double floor_under(const Clip& poses, const SceneQuery& scene);

/// The scene that is assumed where none is given: a flat floor under the feet, around where the person is.
Scene assumed_floor(const Clip& clip);

/// The scene moved up by `by` metres.
Scene raised(const Scene& scene, double by);

}  // namespace inhabit
