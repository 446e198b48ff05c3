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
  int64_t gating = 0;             ///< numbers that the gating network sees
  int64_t encoder_layers = 2;     ///< of each encoder
  int64_t experts = 10;           ///< of the prediction network
  int64_t hidden = 512;           ///< its width
  int64_t gating_first = 128;     ///< width of the gating network's first hidden layer
  int64_t gating_second = 128;    ///< of its second
  int64_t outputs = 0;            ///< numbers that come out
  double dropout = 0.3;           ///< in training

  bool operator==(const PoseSizes&) const = default;  ///< compares all sizes
};

/// Numbers of a frame as the config has them (docs of Eq. 3): what the five encoders see, what the gating network sees
/// beyond the control, and what comes out.
struct FrameSizes {
  int64_t pose = 0;     ///< {J, T}: joints and trajectory
  int64_t goals = 0;    ///< G
  int64_t ego = 0;      ///< E: the ego-centric grid
  int64_t chair = 0;    ///< I: the chair's voxels
  int64_t control = 0;  ///< C: hands and their phases; what who sits or stands is about to do (Config::seated_habits)
  int64_t gating = 0;   ///< actions and goals with the global phase
  int64_t outputs = 0;  ///< of the next frame
};
/// How many numbers each part of a frame has with these settings.
FrameSizes frame_sizes(const Config& config);

/// PoseNet's: a row is pose 355, goals 117, ego 1408, chair 2048, control 104 (122 with habits), gating 312.
PoseSizes pose_sizes(const Config& config);
/// NSM's: without the control. @param contacts NSM+Control: kContactInputs more goal numbers.
PoseSizes nsm_sizes(const Config& config, bool contacts);

/// PoseNet (sec. 4.3): the next frame from the present one by a mixture of experts whose weights are blended.
/// Parameters carry the released names.
struct PoseNetworkImpl : torch::nn::Module {
  /// With random weights.
  explicit PoseNetworkImpl(const PoseSizes& sizes);

  /// @param x (B, row), standardised. @return (B, outputs), standardised.
  torch::Tensor forward(const torch::Tensor& x);
  /// Weights of the experts (B, experts).
  torch::Tensor gates(const torch::Tensor& x);

  PoseSizes sizes;                              ///< what it was built from
  std::vector<torch::nn::Sequential> encoders;  ///< one for each part of a row
  GatingNetwork gating{nullptr};                ///< the row's end to weights of the experts
  ExpertLayers experts{nullptr};                ///< what the encoders give, joined, to the next frame
};
TORCH_MODULE(PoseNetwork);

}  // namespace inhabit::interact
