#pragma once
#include <functional>

#include "inhabit/anticipate/model_file.h"

namespace inhabit::anticipate {

/// The randomness of futures: rows of one sample depend on its seed alone, not on how many are drawn with it.
struct FutureNoise {
  torch::Tensor z;       ///< (S, Z) normal
  torch::Tensor gumbel;  ///< (S, frames + gamma - 1, C)
  torch::Tensor choice;  ///< (S, frames + gamma - 1, 3) uniform, of what the memory follows
};
/// Draws the noise of S = `samples` futures of `frames` frames; a longer future begins as a shorter one of the same
/// seed does. Gumbel noise is scaled by config.inference.label_temperature.
FutureNoise draw_noise(const Config& config, int64_t samples, int64_t frames, uint64_t seed);

/// What was forecast of S futures of one observation, or one of S observations.
struct Futures {
  torch::Tensor features;  ///< (S, T, F) metres and radians
  torch::Tensor labels;    ///< (S, T) int64 intentions; undefined for a model without them
};

/// What S futures follow, standardised, with labels ahead: frames + gamma - 1 of them. Undefined tensors without a
/// memory. @param past (S, t, F) metres and radians, or one for all.
Followed followed_motion(const Networks& networks, const torch::Tensor& past, const FutureNoise& noise, int64_t frames);

/// The networks step by step, as they are trained. @param past (S, t, F) metres and radians, or one for all (1, t, F).
Futures plain_futures(const Networks& networks, const torch::Tensor& past, const FutureNoise& noise, int64_t frames);

/// The networks that ours are compared with; deterministic. (B, t, F) -> (B, frames, F), metres and radians. LTD and
/// HisRep go on on their own predictions.
torch::Tensor seq2seq_future(const Networks& networks, const torch::Tensor& past, int64_t frames);
/// The future by LTD, `networks.ltd`, shapes and units as of seq2seq_future; it sees the last config.baselines.ltd_past
/// frames of `past`, which must have as many.
torch::Tensor ltd_future(const Networks& networks, const torch::Tensor& past, int64_t frames);
/// The future by HisRep, `networks.hisrep`, shapes and units as of seq2seq_future.
torch::Tensor hisrep_future(const Networks& networks, const torch::Tensor& past, int64_t frames);
/// One of them.
using BaselineFuture = torch::Tensor (*)(const Networks& networks, const torch::Tensor& past, int64_t frames);

/// Futures of the authors' networks: labels for the next four seconds are forecast from the last two, as probabilities,
/// and poses follow them; then again from what was forecast. Arguments as in plain_futures; the Gumbel noise is unused.
Futures released_futures(const Networks& networks, const torch::Tensor& past, const FutureNoise& noise, int64_t frames);

/// What forecasts with the networks of a model, whichever they are (FastFutures, released_futures). Throws Error where
/// they are not there.
using FutureFunction = std::function<Futures(const torch::Tensor& past, const FutureNoise& noise, int64_t frames)>;
/// The function that forecasts with the networks of this model. Throws Error("model", ...) where it has none that
/// forecast intention and pose.
FutureFunction future_function(const Networks& networks);

}  // namespace inhabit::anticipate
