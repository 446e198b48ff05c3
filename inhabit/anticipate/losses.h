#pragma once
#include "inhabit/anticipate/config.h"
#include "inhabit/anticipate/features.h"

namespace inhabit::anticipate {

/// lambda(tau) of Eq. 8 for frames t+1 to t+frames: (frames), falling linearly from lambda(t) = 1 to lambda(t +
/// rec_frames) = 0; all 1 where rec_frames is 0.
torch::Tensor reconstruction_weights(int64_t frames, int64_t rec_frames);

/// Eq. 8: mean over frames and joints of weight times the distance of a joint from the true one, metres.
/// @param features, truth (B, T, F) standardised; @param weights (B, T), 0 beyond the recording.
torch::Tensor pose_reconstruction_loss(const torch::Tensor& features, const torch::Tensor& truth,
                                       const torch::Tensor& weights, const FeatureScale& scale);

/// The same of the root's way: mean absolute error of the four standardised numbers.
torch::Tensor root_reconstruction_loss(const torch::Tensor& features, const torch::Tensor& truth,
                                       const torch::Tensor& weights);

/// Eq. 4: cross-entropy of logits (B, T, C) with labels (B, T), mean over frames with weight (B, T).
torch::Tensor intention_loss(const torch::Tensor& logits, const torch::Tensor& labels, const torch::Tensor& weights);

/// Eq. 5 and 7 for logits of real and forecast input: what the adversary lessens, and, in its non-saturating form, what
/// the forecast does.
torch::Tensor discriminator_loss(const torch::Tensor& real, const torch::Tensor& forecast);
torch::Tensor generator_loss(const torch::Tensor& forecast);

/// What keeps the noise z from being ignored, which no equation of the paper does: for futures a and b (N, T, F) of the
/// same observations, the share that the mean distance of their poses (metres, as APD takes it) lacks of `enough` (N).
torch::Tensor sameness_loss(const torch::Tensor& a, const torch::Tensor& b, const FeatureScale& scale,
                            const torch::Tensor& enough);

/// How much poses of recordings (N, T, F) differ from each other: (N) metres, mean distance of frames T/3 apart.
torch::Tensor pose_spread(const torch::Tensor& frames, const FeatureScale& scale);

}  // namespace inhabit::anticipate
