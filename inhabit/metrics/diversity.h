#pragma once
#include <torch/types.h>

namespace inhabit {

/// Average pairwise distance (APD) of futures of one observation: (T) mean over all pairs of samples of the Euclidean
/// distance between their poses in each frame.
/// @param samples (S, T, D), S > 1.
torch::Tensor average_pairwise_distance(const torch::Tensor& samples);

/// APD as published tables have it (Table 5 of the anticipation paper): the mean over all pairs of samples of the
/// Euclidean distance between whole futures, every number of every frame in one vector. It grows with the root of the
/// frames.
double sequence_pairwise_distance(const torch::Tensor& samples);

}  // namespace inhabit
