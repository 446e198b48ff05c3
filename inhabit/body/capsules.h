#pragma once
#include <vector>

#include "inhabit/body/body_model.h"

namespace inhabit {

/// A body's capsules for shape `betas`, still in their joints' frames: each grows with the skin that its joint moves
/// most. An undefined tensor means the mean shape.
std::vector<Capsule> shaped_capsules(const BodyModel& model, const torch::Tensor& betas);

}  // namespace inhabit
