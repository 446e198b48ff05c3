#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "inhabit/interact/chair.h"

namespace inhabit::interact {

/// The parts of a chair that hands are sent to by name: "armrest", "front" and "side" (edges of the seat; where it
/// is broad, beside the hip), "back" (the side of the back rest, where it is within reach and no arm rest is before
/// it).
const std::vector<std::string>& contact_areas();

/// A point on the surface of a part of a chair, for the left (0) or right (1) hand of a person who sits there, world
/// metres. Throws Error(name of the chair, ...) where it has no such part on that side, or the part is unknown.
Eigen::Vector3d contact_on(const Chair& chair, const std::string& area, int side);

/// Where a hand is to go: nowhere, a part of the chair by name ("none": nowhere too), or a point in world metres.
using ContactPlace = std::variant<std::monostate, std::string, Eigen::Vector3d>;

/// The point that is meant for the left (0) or right (1) hand, nothing where it is free. Throws as contact_on.
std::optional<Eigen::Vector3d> contact_at(const Chair& chair, const ContactPlace& place, int side);

}  // namespace inhabit::interact
