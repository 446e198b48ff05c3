#pragma once
#include "inhabit/anticipate/config.h"
#include "inhabit/anticipate/features.h"

namespace inhabit::anticipate {

/// lambda(tau) of Eq. 8 for frames t + 1 to t + frames: (frames). Falls linearly from lambda(t) = 1 to
/// lambda(t + rec_frames) = 0; all ones where rec_frames is 0.
torch::Tensor reconstruction_weights(int64_t frames, int64_t rec_frames);

/// Eq. 8: weighted mean joint error over frames and joints, metres.
/// @param features, truth (B, T, F) standardised; @param weights (B, T), 0 beyond the end of the recording.
torch::Tensor pose_reconstruction_loss(const torch::Tensor& features, const torch::Tensor& truth,
                                       const torch::Tensor& weights, const FeatureScale& scale);

/// The same for the root motion: weighted mean absolute error of its four standardised features.
torch::Tensor root_reconstruction_loss(const torch::Tensor& features, const torch::Tensor& truth,
                                       const torch::Tensor& weights);

/// Eq. 4: weighted mean over frames of the cross-entropy between logits (B, T, C) and labels (B, T); weights (B, T).
torch::Tensor intention_loss(const torch::Tensor& logits, const torch::Tensor& labels, const torch::Tensor& weights);

/// Eq. 5 and 7. Losses of the discriminator and of the generator (non-saturating form) from the discriminator's logits
/// for real and for forecast input.
torch::Tensor discriminator_loss(const torch::Tensor& real, const torch::Tensor& forecast);
/// The generator's loss: mean softplus of minus the discriminator's logits for forecast input.
torch::Tensor generator_loss(const torch::Tensor& forecast);

/// Diversity loss, so that the network does not ignore the noise z (not in the paper): mean of max(0, 1 - d / enough),
/// where d (N) is the mean pose distance in metres (as in APD) between futures a and b (N, T, F) of the same
/// observation.
torch::Tensor diversity_loss(const torch::Tensor& a, const torch::Tensor& b, const FeatureScale& scale,
                             const torch::Tensor& enough);

/// Spread of the poses in recordings (N, T, F): (N) metres, the mean distance of poses T/3 frames apart.
torch::Tensor pose_spread(const torch::Tensor& frames, const FeatureScale& scale);

}  // namespace inhabit::anticipate
