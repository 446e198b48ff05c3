#pragma once
#include "inhabit/body/body_model.h"
#include "inhabit/synth/perform.h"
#include "inhabit/synth/room.h"

namespace inhabit {

/// Metres that a segment with radius reaches into a box, 0 when apart. The box is axis-aligned in the segment's frame.
double capsule_in_box(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius, const Box& box);

/// How deep the body's capsules get into walls and furniture, metres, over all frames. The seat in use does not count.
/// @param capsules of the person's own shape (shaped_capsules).
double deepest_collision(const Room& room, const std::vector<Capsule>& capsules, const Performance& performance);

/// The same for one piece and the capsules given, in use or not.
double deepest_in(const Furniture& piece, const std::vector<Capsule>& capsules, const Performance& performance);

}  // namespace inhabit
