#pragma once
#include "inhabit/motion/clip.h"
#include "inhabit/scene/query.h"

namespace inhabit {

/// Height of what a person's feet stand on in a scene, metres: the middle one of the surfaces, or points of a cloud,
/// straight below the balls of the feet (standard joints) and near to where the poses have the floor (motion/floor.h);
/// where the scene has nothing there, what the poses say.
double floor_under(const Clip& poses, const SceneQuery& scene);

/// The scene that is assumed where none is given: a flat floor under the feet, around where the person is.
Scene assumed_floor(const Clip& clip);

}  // namespace inhabit
