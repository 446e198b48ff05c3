#pragma once
#include <torch/torch.h>

#include <vector>

#include "inhabit/interact/config.h"
#include "inhabit/interact/expert_layers.h"

namespace inhabit::interact {

/// Numbers that NSM+Control and SAMP+Control see of the contacts, at the end of the goals: for the left hand, then the
/// right, the point relative to the root and 1 where there is one (else all four are 0).
inline constexpr int64_t kContactInputs = 8;

/// What a PoseNetwork is built from. A row of its input is the encoders' inputs one after the other; the gating
/// network sees the row's last `gating` numbers.
struct PoseSizes {
  std::vector<int64_t> inputs;    ///< of each encoder: {J, T}, G, E, I and, where it is controlled, C
  std::vector<int64_t> encoders;  ///< widths of the encoders
  int64_t row = 0;                ///< numbers of a row
  int64_t gating = 0;
  int64_t encoder_layers = 2;
  int64_t experts = 10, hidden = 512;
  int64_t gating_first = 128, gating_second = 128;  ///< widths of the gating network's hidden layers
  int64_t outputs = 0;
  double dropout = 0.3;  ///< in training

  bool operator==(const PoseSizes&) const = default;
};

/// Numbers of a frame as the config has them (docs of Eq. 3): what the five encoders see, what the gating network sees
/// beyond the control, and what comes out.
struct FrameSizes {
  int64_t pose = 0, goals = 0, ego = 0, chair = 0, control = 0, gating = 0, outputs = 0;
};
FrameSizes frame_sizes(const Config& config);

/// PoseNet's: a row is pose 355, goals 117, ego 1408, chair 2048, control 104, gating 312.
PoseSizes pose_sizes(const Config& config);
/// NSM's: without the control. @param contacts NSM+Control: kContactInputs more goal numbers.
PoseSizes nsm_sizes(const Config& config, bool contacts);

/// PoseNet (sec. 4.3): the next frame from the present one by a mixture of experts whose weights are blended.
/// Parameters carry the released names.
struct PoseNetworkImpl : torch::nn::Module {
  explicit PoseNetworkImpl(const PoseSizes& sizes);

  /// @param x (B, row), standardised. @return (B, outputs), standardised.
  torch::Tensor forward(const torch::Tensor& x);
  /// Weights of the experts (B, experts).
  torch::Tensor gates(const torch::Tensor& x);

  PoseSizes sizes;
  std::vector<torch::nn::Sequential> encoders;
  GatingNetwork gating{nullptr};
  ExpertLayers experts{nullptr};
};
TORCH_MODULE(PoseNetwork);

}  // namespace inhabit::interact
