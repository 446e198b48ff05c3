#pragma once
#include <torch/torch.h>

#include <utility>

#include "inhabit/anticipate/config.h"
#include "inhabit/nn/latent_distribution.h"

namespace inhabit::anticipate {

// Stochastic methods that ours is compared with. Features (F) are standardised, as in network.h.

/// The conditional variational autoencoder that DLow draws from (Yuan and Kitani 2020): GRUs read the observation and,
/// in training, the future; one cell decodes pose after pose from the observation's code, z and the pose before. Poses
/// are absolute, so that nothing ties the first to the last observed one.
struct MotionVaeImpl : torch::nn::Module {
  /// Sizes baselines.vae_hidden (H) and vae_latent (Z).
  explicit MotionVaeImpl(const Config& config);

  /// Code of an observation: (B, t, F) -> (B, H).
  torch::Tensor encode(const torch::Tensor& past);
  /// z of a future (B, T, F) behind an observation's code.
  nn::LatentDistribution posterior(const torch::Tensor& code, const torch::Tensor& future);
  /// (B, frames, F) from code (B, H), z (B, Z) and the last observed pose (B, F).
  torch::Tensor decode(const torch::Tensor& code, const torch::Tensor& z, const torch::Tensor& last, int64_t frames);

  torch::nn::GRU past_encoder{nullptr};     ///< F to H
  torch::nn::GRU future_encoder{nullptr};   ///< F to H
  torch::nn::Sequential posterior_layers;   ///< 2 H to 200
  torch::nn::Linear mean{nullptr};          ///< 200 to Z
  torch::nn::Linear log_variance{nullptr};  ///< 200 to Z
  torch::nn::Sequential start;              ///< H to the decoder's first state (H)
  torch::nn::GRUCell decoder{nullptr};      ///< code, z and pose to H
  torch::nn::Sequential decoder_layers;     ///< H to 200
  torch::nn::Linear out{nullptr};           ///< 200 to F
};
TORCH_MODULE(MotionVae);

/// DLow's sampler (Yuan and Kitani 2020): z_k = a_k e + b_k of K futures from one normal e, so that they differ.
struct LatentSamplerImpl : torch::nn::Module {
  /// Sizes baselines.vae_hidden, vae_latent (Z) and dlow_samples (K).
  explicit LatentSamplerImpl(const Config& config);
  /// a and b, (B, K, Z) each, of an observation (B, t, F).
  std::pair<torch::Tensor, torch::Tensor> forward(const torch::Tensor& past);

  torch::nn::GRU encoder{nullptr};    ///< F to H
  torch::nn::Sequential layers;       ///< H to 512
  torch::nn::Linear factor{nullptr};  ///< 512 to K Z
  torch::nn::Linear shift{nullptr};   ///< 512 to K Z
  int64_t samples = 0;                ///< K
  int64_t latent = 0;                 ///< Z
};
TORCH_MODULE(LatentSampler);

/// Mix-and-Match (Aliakbarian et al. 2020): half of the future's code, at places that are drawn anew each time, and the
/// rest of the observation's code are mixed, and a variational autoencoder makes z of the mixture. What it decodes
/// takes the same places of the observation's code, from which a residual GRU goes on.
struct MixMatchNetworkImpl : torch::nn::Module {
  /// Sizes baselines.mix_hidden (H) and mix_latent (Z).
  explicit MixMatchNetworkImpl(const Config& config);

  /// Code of motion: (B, t, F) -> (B, H).
  torch::Tensor encode(const torch::Tensor& past);
  /// z of the mixture of both codes. @param taken (H) or (B, H) 1 at the places of the future's code, else 0.
  nn::LatentDistribution posterior(const torch::Tensor& code, const torch::Tensor& future, const torch::Tensor& taken);
  /// (B, frames, F) from the observation's code, z, the places taken and the last observed pose (B, F).
  torch::Tensor decode(const torch::Tensor& code, const torch::Tensor& z, const torch::Tensor& taken,
                       const torch::Tensor& last, int64_t frames);

  torch::nn::GRU past_encoder{nullptr};     ///< F to H
  torch::nn::GRU future_encoder{nullptr};   ///< F to H
  torch::nn::Linear mean{nullptr};          ///< H to Z
  torch::nn::Linear log_variance{nullptr};  ///< H to Z
  torch::nn::Linear from_latent{nullptr};   ///< Z to H
  torch::nn::GRUCell decoder{nullptr};      ///< pose to H
  torch::nn::Linear out{nullptr};           ///< H to a change (F)
};
TORCH_MODULE(MixMatchNetwork);

/// DLow's diversity term of K futures (B, K, D): mean over pairs of exp(-d^2 / scale), d being their distance.
torch::Tensor sameness_of_pairs(const torch::Tensor& futures, double scale);

}  // namespace inhabit::anticipate
