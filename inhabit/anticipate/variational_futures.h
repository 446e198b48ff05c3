#pragma once
#include <random>

#include "inhabit/anticipate/model_file.h"
#include "inhabit/anticipate/sample.h"

namespace inhabit::anticipate {

// Futures of the stochastic methods that ours is compared with: past (1, t, F) of one observation -> (S, frames, F),
// metres and radians. Networks forecast config.future frames at a time and go on from these, with the z they began
// with.

/// `networks.vae`, z drawn from N(0, 1).
torch::Tensor vae_futures(const Networks& networks, const torch::Tensor& past, int64_t samples, int64_t frames,
                          uint64_t seed);
/// `networks.vae` with z of `networks.dlow`: baselines.dlow_samples of one draw (fewer: the first
/// of them), then more draws.
torch::Tensor dlow_futures(const Networks& networks, const torch::Tensor& past, int64_t samples, int64_t frames,
                           uint64_t seed);
/// `networks.mix_match`, z and the places of the code that it takes drawn for each future.
torch::Tensor mix_match_futures(const Networks& networks, const torch::Tensor& past, int64_t samples, int64_t frames,
                                uint64_t seed);
/// `networks.grammar`, production rules drawn for each frame of each future.
torch::Tensor grammar_futures(const Networks& networks, const torch::Tensor& past, int64_t samples, int64_t frames,
                              uint64_t seed);
/// One of them.
using StochasticFutures = torch::Tensor (*)(const Networks& networks, const torch::Tensor& past, int64_t samples,
                                            int64_t frames, uint64_t seed);

/// 1 for half of `count` places, drawn, else 0: (count).
torch::Tensor half_of_places(int64_t count, std::mt19937_64& random);

/// Pose error of the best of so many futures (futures_error, metrics/forecast_error.h), metres, over the first second
/// of each validation window: the mean.
double nearest_validation_error(const Networks& networks, StochasticFutures method, int64_t futures,
                                const std::vector<Sequence>& sequences);

}  // namespace inhabit::anticipate
