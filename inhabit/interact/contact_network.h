#pragma once
#include <torch/torch.h>

#include "inhabit/interact/config.h"
#include "inhabit/nn/latent_distribution.h"

namespace inhabit::interact {

/// Numbers of ContactNet's contacts: points of two hands.
inline constexpr int64_t kContactPoints = 6;

/// ContactNet (sec. 4.4): a conditional variational auto-encoder of hand contacts on a chair. Parameters carry the
/// released names. Positions are metres relative to the centre of the chair.
struct ContactNetworkImpl : torch::nn::Module {
  /// Sizes contact_hidden, contact_code, contact_z and the chair's grid.
  explicit ContactNetworkImpl(const Config& config);

  /// @param contacts (B, 6); @param chair (B, 2048) positions and values of the voxels.
  nn::LatentDistribution encode(const torch::Tensor& contacts, const torch::Tensor& chair);
  /// @param z (B, z). @return contacts (B, 6).
  torch::Tensor decode(const torch::Tensor& z, const torch::Tensor& chair);

  /// Encoder or decoder.
  struct Half : torch::nn::Module {
    torch::nn::Sequential cond_encoder1{nullptr};  ///< the chair's grid to its code
    torch::nn::Sequential main{nullptr};           ///< contacts or z, with the code of the chair, on
    torch::nn::Linear fc1{nullptr};                ///< to the mean: of the encoder alone
    torch::nn::Linear fc2{nullptr};                ///< to the log variance: of the encoder alone
  };
  std::shared_ptr<Half> encoder;  ///< contacts to a distribution of z
  std::shared_ptr<Half> decoder;  ///< z to contacts
};
TORCH_MODULE(ContactNetwork);

}  // namespace inhabit::interact
