#pragma once
#include <torch/torch.h>

#include <vector>

#include "inhabit/forecast/network.h"
#include "inhabit/nn/row_layers.h"

namespace inhabit::forecast {

/// Inference-only evaluation of a motion network on the CPU: the same outputs as MotionNetworkImpl::forward() in
/// evaluation mode, each sample decoded frame by frame in plain loops, without a graph and without allocating per
/// frame. Holds a copy of the weights; forward() may be called from several threads.
class FastMotionNetwork {
 public:
  explicit FastMotionNetwork(const MotionNetwork& network);

  /// @param past (B, P, J, 3); @param contact_points (B, T, J, 4), may be undefined for the no-contact variant.
  MotionForecast forward(const torch::Tensor& past, const torch::Tensor& contact_points) const;

 private:
  void run(const float* past_local, const float* path_dct, const float* contact_points, float* root_path,
           float* local) const;

  Config config_;
  bool with_contact_;
  nn::RowLayer encode_past_, encode_contact_, decode_in_, decode_out_;
  nn::RowGru past_gru_, contact_gru_, decode_gru_;
  std::vector<nn::RowLayer> path_layers_;  ///< the residual MLP's five hidden layers, then its output
  torch::Tensor padded_dct_, idct_;
};

}  // namespace inhabit::forecast
