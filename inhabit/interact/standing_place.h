#pragma once
#include <Eigen/Core>
#include <functional>
#include <optional>

#include "inhabit/interact/chair.h"
#include "inhabit/motion/clip.h"

namespace inhabit::interact {

class Surroundings;

/// Whether somebody can stand at (x, z): nothing within 28 cm from shin to shoulder.
bool room_to_stand(const Surroundings& around, const Eigen::Vector2d& place);

/// The place (x, z) nearest to one, 12 m at most, that is free; nothing where none is.
std::optional<Eigen::Vector2d> nearest_free(const Eigen::Vector2d& wanted,
                                            const std::function<bool(const Eigen::Vector2d&)>& free);

/// Somebody who stands where there is room and a route to a seat, as near as can be to 2 m before it, and looks at it.
/// Throws Error(chair.name, ...) where there is none.
Clip standing_before(const Chair& chair, const Scene& scene);

}  // namespace inhabit::interact
