#pragma once
#include <torch/torch.h>

#include <cstdint>

#include "inhabit/inbetween/config.h"
#include "inhabit/inbetween/poses.h"

namespace inhabit::inbetween {

/// When feet are in contact, from what the denoiser of residual motion knows at its last evaluation: the features that
/// its output is read from. Two convolutions over time.
struct FootContactNetImpl : torch::nn::Module {
  /// @param channels C, of the features
  explicit FootContactNetImpl(int64_t channels);
  /// @param features (B, C, T) of DenoiserImpl::features. @return (B, 4, T) logits, in the order of kFootJoints
  torch::Tensor forward(const torch::Tensor& features);

  torch::nn::Conv1d mix{nullptr};   ///< C to 32, kTaps taps
  torch::nn::Conv1d tell{nullptr};  ///< 32 to 4, one tap
};
TORCH_MODULE(FootContactNet);
/// Of a denoiser of this configuration, with weights drawn at random by LibTorch's global generator.
FootContactNet foot_contact_net(const Config& config);

/// Labels (T, 4), 1 where a foot is in contact in recorded or generated motion (refine/contacts.h). @param poses with
/// the floor at height 0
torch::Tensor foot_contacts(const Poses& poses, double rate);

}  // namespace inhabit::inbetween
