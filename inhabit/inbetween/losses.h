#pragma once
#include <torch/types.h>

#include <string>
#include <utility>
#include <vector>

#include "inhabit/nn/feature_scale.h"

namespace inhabit::inbetween {

struct Config;

/// Named terms of Eq. 4 for predictions of standardised features (B, 201, T); "total" comes first. Joints and their
/// velocities (Eq. 2, 3) count in units of 0.3 m, which makes them about as large as standardised features.
/// @param bones (B, 22, 3) metres; @param scale (201).
std::vector<std::pair<std::string, torch::Tensor>> loss_terms(const torch::Tensor& predicted,
                                                              const torch::Tensor& truth, const torch::Tensor& bones,
                                                              const FeatureScale& scale, const Config& config);

}  // namespace inhabit::inbetween
