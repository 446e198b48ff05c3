#pragma once
#include <torch/torch.h>

#include <vector>

#include "inhabit/forecast/articulated_network.h"

namespace inhabit::forecast {

/// Futures that a person may have, and how likely each is.
struct Hypotheses {
  torch::Tensor joints;           ///< (B, K, T, 22, 3), axes of the window
  torch::Tensor log_probability;  ///< (B, K)
};

/// Says in what ways the person may go on, beside the one forecast of the articulated network: K motions, each what is
/// added to the coefficients of that forecast, and how likely each is. Trained so that one of them is near what happens
/// (winner takes all), where the one forecast is trained to be near it in the mean. Two blocks of its own behind those
/// of the articulated network, whose weights stay as they are.
struct HypothesesNetworkImpl : torch::nn::Module {
  /// K = config.articulated.hypotheses, over 0.
  explicit HypothesesNetworkImpl(const Config& config);

  /// @param network whose forecast they differ from. @param seen what it made of the past, without gradients
  Hypotheses forward(ArticulatedNetwork network, const ArticulatedNetworkImpl::Seen& seen);

  Config config;                                      ///< what it was made with
  std::vector<ArticulatedNetworkImpl::Block> blocks;  ///< one after the other
  torch::nn::LayerNorm out_norm{nullptr};             ///< behind the last block
  torch::nn::Linear coefficients{nullptr};            ///< S tokens to DCT coefficients over the future
  torch::nn::Linear out{nullptr};                     ///< width to K times the numbers that are added
  torch::nn::Linear likely{nullptr};                  ///< the mean over tokens to K logits
};
TORCH_MODULE(HypothesesNetwork);

/// How far each of the hypotheses is from what happens, (B, K) metres: mean distances of the root, of the other joints
/// relative to it, and of steps of joints, by config.training's weights (articulated_losses).
/// @param joints (B, K, T, J, 3) of Hypotheses. @param last (B, J, 3) the last observed joints, future (B, T, J, 3) the
/// true ones.
torch::Tensor hypothesis_errors(const torch::Tensor& joints, const torch::Tensor& last, const torch::Tensor& future,
                                const Config& config);

}  // namespace inhabit::forecast
