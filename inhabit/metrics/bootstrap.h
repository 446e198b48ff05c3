#pragma once
#include <torch/types.h>

#include <cstdint>
#include <vector>

namespace inhabit {

// Intervals by bootstrap (Efron 1979): a statistic of N items is computed again over N of them drawn with replacement.
// Whoever compares two sets of the same items takes the same draws for both, so that what they have in common cancels.

/// How often each item is in each resample: (resamples, items) double, rows sum to `items`. From the seed alone.
/// Throws Error for fewer than one of either.
torch::Tensor bootstrap_counts(int64_t items, int64_t resamples, uint64_t seed);

/// Half of the 95 % interval: half of the distance from the 2.5th to the 97.5th percentile of the statistics, linear
/// between ranks. Statistics that are not finite are left out; 0 where fewer than two are left.
double half_interval(std::vector<double> statistics);

/// sum(numerators) / sum(denominators) over each resample; NaN where the denominators sum to 0.
/// @param numerators, denominators (items) double; @param counts of bootstrap_counts
std::vector<double> resampled_ratios(const torch::Tensor& numerators, const torch::Tensor& denominators,
                                     const torch::Tensor& counts);

}  // namespace inhabit
