#pragma once
#include <string>

#include "inhabit/anticipate/features.h"
#include "inhabit/anticipate/network.h"
#include "inhabit/train/loop.h"

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

/// What discriminators see the changes of standardised poses times, which are some 0.2 a frame.
constexpr double kVelocityScale = 5;
/// Adds the loss of a discriminator of `real` (N, D) and `forecast` (M, D), with a gradient penalty on real input (R1),
/// and `weight` times the generator loss of the forecast, which leaves the discriminator as it is, to `total`. Both are
/// appended to `losses` as NAME_discriminator and NAME_generator.
void add_discriminator(Discriminator discriminator, const std::string& name, const torch::Tensor& real,
                       const torch::Tensor& forecast, double weight, torch::Tensor& total, Losses& losses);
/// TrainTask::rate_factor: parameters of modules whose name holds "discriminator" learn at twice the rate.
double faster_discriminators(const std::string& parameter);

/// Diversity loss, so that the network does not ignore the noise z (not in the paper): mean of max(0, 1 - d / enough),
/// where d (N) is the mean pose distance in metres (as in APD) between futures a and b (N, T, F) of the same
/// observation.
torch::Tensor diversity_loss(const torch::Tensor& a, const torch::Tensor& b, const FeatureScale& scale,
                             const torch::Tensor& enough);

/// Spread of the poses in recordings (N, T, F): (N) metres, the mean distance of poses T/3 frames apart.
torch::Tensor pose_spread(const torch::Tensor& frames, const FeatureScale& scale);

}  // namespace inhabit::anticipate
