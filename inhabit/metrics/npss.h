#pragma once
#include <torch/types.h>

namespace inhabit {

/// Normalised power spectrum similarity (Gopalakrishnan et al.) in the form used with LaFAN1: squared real part of
/// each feature's spectrum over time, normalised, cumulated, L1 distance, averaged with the true sequence's power as
/// weight. 0 is equal; lower is better. Features that never change in truth or forecast carry no spectrum and are left
/// out.
/// @param truth, forecast (B, T, D)
double npss(const torch::Tensor& truth, const torch::Tensor& forecast);

}  // namespace inhabit
