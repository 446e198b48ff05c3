#pragma once
#include <torch/torch.h>

#include <memory>
#include <vector>

#include "inhabit/forecast/config.h"

namespace inhabit::forecast {

/// How fine a body is looked at: its 22 standard joints, ten parts (halves of arms and legs, trunk, head) or five
/// (arms, legs, trunk with head).
struct BodyScale {
  torch::Tensor members;    ///< (S, 22) what each part is the mean of: rows sum to 1
  torch::Tensor adjacency;  ///< (2, S, S) from row to column: each part to itself, to its neighbours; columns of both
                            ///< together sum to 1
};
/// The three scales, finest first.
std::vector<BodyScale> body_scales();

struct DmgnnEncoderImpl;

/// DMGNN (Li et al. 2020, "Dynamic Multiscale Graph Neural Networks for 3D Skeleton-Based Human Motion Prediction"):
/// encoders of the observed motion, its velocities and its accelerations, each over graphs of the body at three scales
/// that tell each other what they see, then a recurrent cell on the graph of joints, which adds a step to every joint.
struct DmgnnNetworkImpl : torch::nn::Module {
  /// P, T and baselines.dmgnn_width of the configuration. Throws Error unless it has the standard 22 joints and
  /// observes three frames or more.
  explicit DmgnnNetworkImpl(const Config& config);
  /// World joints (B, P, 22, 3) -> (B, T, 22, 3), origin at the root of the last observed frame.
  torch::Tensor forward(const torch::Tensor& past);

  int64_t future;                                           ///< T frames
  std::vector<std::shared_ptr<DmgnnEncoderImpl>> encoders;  ///< of motion, velocities, accelerations
  torch::nn::Linear start{nullptr};                         ///< the three codes of a joint to the cell's first state
  torch::Tensor edge_factor;                                ///< (2, 22, 22) what the cell multiplies adjacency by
  torch::Tensor edge_offset;                                ///< (2, 22, 22) what it adds to that
  torch::nn::Linear message{nullptr};       ///< a joint's state to what it tells itself and its neighbours
  torch::nn::Linear motion_gates{nullptr};  ///< place, velocity and acceleration to the three gates
  torch::nn::Linear state_gates{nullptr};   ///< what the joint is told to the same
  torch::nn::Sequential step;               ///< a joint's state to its step, metres

 private:
  torch::Tensor adjacency_;
};
TORCH_MODULE(DmgnnNetwork);

}  // namespace inhabit::forecast
