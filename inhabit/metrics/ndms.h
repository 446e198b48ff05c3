#pragma once
#include "inhabit/metrics/motion_words.h"

namespace inhabit {

/// Normalised directional motion similarity (Eq. 11-12) of words (N, kappa, J, 3) with as many others: (N) in [0, 1].
/// Velocities are frame differences. Lengths are floored at 1e-7, so that a joint at rest in both words scores
/// as floored vectors do: 1/2 (no direction, equal length).
torch::Tensor ndms(const torch::Tensor& words, const torch::Tensor& others);

/// g of Eq. 10: (N) similarity of each word with the one nearest to it in the database.
torch::Tensor plausibility(const torch::Tensor& words, const WordIndex& database);

}  // namespace inhabit
