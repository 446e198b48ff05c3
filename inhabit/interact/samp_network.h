#pragma once
#include <torch/torch.h>

#include "inhabit/interact/contact_network.h"
#include "inhabit/interact/expert_layers.h"

namespace inhabit::interact {

/// SAMP's motion network (Hassan et al. 2021), a baseline: a conditional variational auto-encoder of the next frame
/// whose decoder is a mixture of experts. It takes the rows that NSM takes (nsm_sizes(), with contacts or without) and
/// reads the pose, the goals and the chair from them: neither the ego-centric grid nor the phases. Outputs are
/// PoseNet's.
struct SampNetworkImpl : torch::nn::Module {
  /// @param contacts SAMP+Control: kContactInputs more goal numbers.
  SampNetworkImpl(const Config& config, bool contacts);

  /// @param next (B, outputs) the frame that followed; @param x (B, row); both standardised.
  nn::LatentDistribution encode(const torch::Tensor& next, const torch::Tensor& x);
  /// @param z (B, z). @return the next frame (B, outputs).
  torch::Tensor decode(const torch::Tensor& z, const torch::Tensor& x);

  int64_t row = 0;                               ///< numbers of a row of x
  int64_t z = 0;                                 ///< numbers of z
  torch::nn::Sequential chair_encoder{nullptr};  ///< the chair's grid to its code
  torch::nn::Sequential state_encoder{nullptr};  ///< the next frame and what it follows, on to mean and variance
  torch::nn::Linear mean{nullptr};               ///< of z
  torch::nn::Linear log_variance{nullptr};       ///< of z
  GatingNetwork gating{nullptr};                 ///< weights of the experts
  ExpertLayers experts{nullptr};                 ///< z and what the next frame follows to that frame

 private:
  torch::Tensor condition(const torch::Tensor& x);
  int64_t state_ = 0, chair_first_ = 0, chair_ = 0;
};
TORCH_MODULE(SampNetwork);

}  // namespace inhabit::interact
