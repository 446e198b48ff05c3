#pragma once
#include <torch/torch.h>

namespace inhabit::nn {

/// A normal distribution of the latent code z of a variational autoencoder: mean and logarithm of the variance, both
/// (B, z).
struct LatentDistribution {
  torch::Tensor mean;          ///< (B, z)
  torch::Tensor log_variance;  ///< (B, z)

  /// z = mean + deviation noise, differentiable. @param noise (B, z) from N(0, 1).
  torch::Tensor sample(const torch::Tensor& noise) const { return mean + (0.5 * log_variance).exp() * noise; }
  /// KL divergence from N(0, I), the mean over batch and numbers.
  torch::Tensor divergence() const { return -0.5 * (1 + log_variance - mean.square() - log_variance.exp()).mean(); }
  /// The same, the sum over numbers and mean over the batch.
  torch::Tensor summed_divergence() const { return mean.size(1) * divergence(); }
};

}  // namespace inhabit::nn
