#pragma once
#include <vector>

#include "inhabit/body/body_model.h"
#include "inhabit/body/bones.h"

namespace inhabit {

/// A capsule in the world, metres: the points within `radius` of the segment from a to b.
struct WorldCapsule {
  int joint = 0;
  Eigen::Vector3d a, b;
  double radius = 0;
};

/// A body's capsules for shape `betas`, still in their joints' frames: each grows with the skin that its joint moves
/// most. An undefined tensor means the mean shape.
std::vector<Capsule> shaped_capsules(const BodyModel& model, const torch::Tensor& betas);

/// Capsules carried along by a posed skeleton. `out` is resized; nothing is allocated when it already has the right
/// size.
void place_capsules(const std::vector<Capsule>& capsules, const BonesPose& pose, std::vector<WorldCapsule>& out);

/// Least distance, metres, between two capsules' surfaces; negative where they overlap.
double capsule_distance(const WorldCapsule& first, const WorldCapsule& second);

}  // namespace inhabit
