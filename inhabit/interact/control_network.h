#pragma once
#include <torch/torch.h>

#include "inhabit/interact/config.h"

namespace inhabit::interact {

/// What an LSTM carries from frame to frame, both (layers, B, width).
struct ControlState {
  torch::Tensor hidden;  ///< h
  torch::Tensor cell;    ///< c
};

/// ControlNet (sec. 4.2): plans the hands' trajectories to their contacts. Parameters carry the released names.
struct ControlNetworkImpl : torch::nn::Module {
  /// Of the sizes that the config gives.
  explicit ControlNetworkImpl(const Config& config);

  /// The learnt state that a motion starts with.
  ControlState start(int64_t batch);

  /// One frame. The state is moved on.
  /// @param pose (B, 66) joint positions relative to the root.
  /// @param control (B, 56) points on the straight line to the contact for both hands, present and future keys of
  /// three numbers each (42), then local phases of both hands (14). @return the same of the next frame (B, 56).
  torch::Tensor step(const torch::Tensor& pose, const torch::Tensor& control, ControlState& state);

  /// Frames one after the other: (T, B, 66) and (T, B, 56) -> (T, B, 56).
  torch::Tensor forward(const torch::Tensor& pose, const torch::Tensor& control, ControlState& state);

  torch::nn::Sequential encoder1{nullptr};  ///< of the pose
  torch::nn::Sequential encoder2{nullptr};  ///< of the control
  torch::nn::LSTM rnn{nullptr};             ///< over the frames
  torch::nn::Linear fc{nullptr};            ///< to the next control
  torch::Tensor h0;                         ///< (layers, 1, width) learnt
  torch::Tensor c0;                         ///< (layers, 1, width) learnt
};
TORCH_MODULE(ControlNetwork);

/// Slope under 0 of the encoders' leaky rectifiers.
inline constexpr double kControlLeak = 0.05;

}  // namespace inhabit::interact
