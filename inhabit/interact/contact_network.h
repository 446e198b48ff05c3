#pragma once
#include <torch/torch.h>

#include "inhabit/interact/config.h"

namespace inhabit::interact {

/// A normal distribution of z: mean and logarithm of the variance, both (B, z).
struct LatentDistribution {
  torch::Tensor mean, log_variance;

  /// z = mean + deviation noise, differentiable. @param noise (B, z) from N(0, 1).
  torch::Tensor sample(const torch::Tensor& noise) const { return mean + (0.5 * log_variance).exp() * noise; }
  /// KL divergence from N(0, I), the mean over batch and numbers.
  torch::Tensor divergence() const { return -0.5 * (1 + log_variance - mean.square() - log_variance.exp()).mean(); }
};

/// Numbers of ContactNet's contacts: points of two hands.
inline constexpr int64_t kContactPoints = 6;

/// ContactNet (sec. 4.4): a conditional variational auto-encoder of hand contacts on a chair. Parameters carry the
/// released names. Positions are metres relative to the centre of the chair.
struct ContactNetworkImpl : torch::nn::Module {
  explicit ContactNetworkImpl(const Config& config);

  /// @param contacts (B, 6); @param chair (B, 2048) positions and values of the voxels.
  LatentDistribution encode(const torch::Tensor& contacts, const torch::Tensor& chair);
  /// @param z (B, z). @return contacts (B, 6).
  torch::Tensor decode(const torch::Tensor& z, const torch::Tensor& chair);

  struct Half : torch::nn::Module {
    torch::nn::Sequential cond_encoder1{nullptr}, main{nullptr};
    torch::nn::Linear fc1{nullptr}, fc2{nullptr};  ///< mean and log variance: of the encoder alone
  };
  std::shared_ptr<Half> encoder, decoder;
};
TORCH_MODULE(ContactNetwork);

}  // namespace inhabit::interact
