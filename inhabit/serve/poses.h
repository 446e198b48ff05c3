#pragma once
#include <string>
#include <vector>

#include "inhabit/serve/frames.h"
#include "inhabit/serve/world.h"

namespace inhabit::serve {

/// Names of the poses that a person can be told to take: "standing", "crouching", "reaching up", "arms wide", "step".
const std::vector<std::string>& pose_names();

/// A pose at a place (x, z) metres on the floor, looking along `heading` (radians). Throws Error where the name is none
/// of pose_names(), or nobody can stand there.
Frame pose_at(const World& world, const std::string& name, const Eigen::Vector2d& place, double heading);

}  // namespace inhabit::serve
