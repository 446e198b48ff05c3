#pragma once
#include <torch/torch.h>

#include <vector>

#include "inhabit/anticipate/config.h"

namespace inhabit::anticipate {

/// Numbers a frame that the networks see (F): 21 joints of the local pose, root left out, and the root's way (4), each
/// less its mean and over its deviation in the training set.
inline constexpr int64_t kPoseFeatures = 63, kFeatureCount = kPoseFeatures + 4;

/// Forecasts the intention (3.1): a recurrent encoder over the observation and an autoregressive decoder over labels.
struct IntentionNetworkImpl : torch::nn::Module {
  explicit IntentionNetworkImpl(const Config& config);

  /// Decoder state (B, H) after an observation (B, t, F).
  torch::Tensor encode(const torch::Tensor& past);
  /// Logits (B, T, C) of every label given the true ones before it, one-hot (B, T, C).
  torch::Tensor teacher_logits(torch::Tensor state, const torch::Tensor& labels);
  /// Labels drawn one after the other, one-hot (B, T, C), from Gumbel noise (B, T, C). Their gradient is that of the
  /// softmax (straight through).
  torch::Tensor draw(torch::Tensor state, const torch::Tensor& gumbel);

  torch::nn::GRU encoder{nullptr};
  torch::nn::GRUCell decoder{nullptr};
  torch::nn::Linear out{nullptr};
};
TORCH_MODULE(IntentionNetwork);

/// Forecasts poses from observation, intention and noise (3.2, Eq. 6). A pose is the one before, plus a change, and
/// drawn by a learned share towards a pose that the state names: changes alone add up and drift off in half a minute.
struct PoseNetworkImpl : torch::nn::Module {
  explicit PoseNetworkImpl(const Config& config);

  /// What goes on from frame to frame: the states of the three layers (B, H) and the last pose (B, F).
  struct State {
    std::vector<torch::Tensor> layers;
    torch::Tensor pose;
  };
  /// @param past (B, t, F); @param z (B, Z) normal.
  State start(const torch::Tensor& past, const torch::Tensor& z);
  /// The next T frames (B, T, F). @param intention (B, T + gamma - 1, C): of frame i on, read by frame i to i + gamma -
  /// 1; undefined where the decoder does not see it. `state` goes on.
  torch::Tensor roll(State& state, const torch::Tensor& intention, int64_t frames);

  torch::nn::GRU encoder{nullptr};
  std::vector<torch::nn::GRUCell> layers;
  torch::nn::Conv1d look_ahead{nullptr};
  torch::nn::Linear out{nullptr};  ///< change, then pose: (2 F)
  torch::Tensor pull;              ///< (F) logit of the share
  int64_t intention_features = 0;
};
TORCH_MODULE(PoseNetwork);

/// Feed-forward adversary with `depth` hidden layers over flattened input: (N, D) -> (N) logits, above 0 for real.
struct DiscriminatorImpl : torch::nn::Module {
  DiscriminatorImpl(int64_t inputs, int64_t hidden, int depth);
  torch::Tensor forward(const torch::Tensor& x) { return layers->forward(x).squeeze(1); }

  torch::nn::Sequential layers;
};
TORCH_MODULE(Discriminator);

/// The residual sequence-to-sequence GRU (Martinez et al. 2017): one cell reads the observation and goes on on its own
/// predictions, each added to the pose before.
struct Seq2SeqNetworkImpl : torch::nn::Module {
  explicit Seq2SeqNetworkImpl(const Config& config);
  torch::Tensor forward(const torch::Tensor& past, int64_t frames);  ///< (B, t, F) -> (B, frames, F)

  torch::nn::GRU gru{nullptr};
  torch::nn::Linear out{nullptr};
};
TORCH_MODULE(Seq2SeqNetwork);

}  // namespace inhabit::anticipate
