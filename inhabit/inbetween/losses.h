#pragma once
#include <torch/types.h>

#include <string>
#include <utility>
#include <vector>

namespace inhabit::inbetween {

struct Config;

/// Named terms of Eq. 4 for predictions of standardised features (B, 201, T); "total" comes first. Joints and their
/// velocities (Eq. 2, 3) count in units of 0.3 m, which makes them about as large as standardised features.
/// @param bones (B, 22, 3) metres; @param mean, deviation (201).
std::vector<std::pair<std::string, torch::Tensor>> loss_terms(const torch::Tensor& predicted,
                                                              const torch::Tensor& truth, const torch::Tensor& bones,
                                                              const torch::Tensor& mean, const torch::Tensor& deviation,
                                                              const Config& config);

}  // namespace inhabit::inbetween
