#pragma once
#include <torch/torch.h>

#include <vector>

#include "inhabit/anticipate/config.h"
#include "inhabit/anticipate/motion_memory.h"

namespace inhabit::anticipate {

/// Features of a frame (F): 21 joints of the local pose without the root (63), then the root motion (4); standardised
/// by mean and deviation of the training set.
inline constexpr int64_t kPoseFeatures = 63,  ///< of the local pose
    kFeatureCount = kPoseFeatures + 4;        ///< F, all of them

/// The intention network (3.1): a recurrent encoder of the observation and an autoregressive decoder of labels.
struct IntentionNetworkImpl : torch::nn::Module {
  /// Sizes intention_hidden (H) and labels (C).
  explicit IntentionNetworkImpl(const Config& config);

  /// Decoder state (B, H) after an observation (B, t, F).
  torch::Tensor encode(const torch::Tensor& past);
  /// Teacher forcing: logits (B, T, C) of every label, conditioned on the true labels before it, one-hot (B, T, C).
  torch::Tensor teacher_logits(torch::Tensor state, const torch::Tensor& labels);
  /// Samples labels one after the other, one-hot (B, T, C), with Gumbel noise (B, T, C). The gradient is that of the
  /// softmax (straight-through estimator).
  torch::Tensor draw(torch::Tensor state, const torch::Tensor& gumbel);

  torch::nn::GRU encoder{nullptr};      ///< F to H
  torch::nn::GRUCell decoder{nullptr};  ///< the label before (C) to H
  torch::nn::Linear out{nullptr};       ///< H to the logits of C labels
};
TORCH_MODULE(IntentionNetwork);

/// The pose network (3.2, Eq. 6): forecasts poses from observation, intention and noise z. In each frame the decoder
/// predicts a change d and a target pose q from its state. With a learned weight w of each feature,
///   p(t + 1) = p(t) + d + w (q - p(t)).
/// Changes alone (w = 0) accumulate and drift within half a minute. With a memory, where m(t) is the frame that is
/// followed and c(t) the change to it in its recording, d and q are what differs from these:
///   p(t + 1) = p(t) + c(t + 1) + d + w (m(t + 1) + q - p(t)).
struct PoseNetworkImpl : torch::nn::Module {
  /// Sizes hidden (H), noise (Z), labels (C), intention_features and gamma.
  explicit PoseNetworkImpl(const Config& config);

  /// The recurrent state: hidden states of the three layers (B, H) and the last pose (B, F).
  struct State {
    std::vector<torch::Tensor> layers;  ///< one of each, (B, H)
    torch::Tensor pose;                 ///< (B, F) standardised
  };
  /// The state after an observation. @param past (B, t, F); @param z (B, Z) normal.
  State start(const torch::Tensor& past, const torch::Tensor& z);
  /// The next T frames (B, T, F); advances `state`. @param intention (B, T + gamma - 1, C): frame i reads labels i to
  /// i + gamma - 1; undefined where the decoder does not see the intention. @param followed standardised, (B, T, F) or
  /// more frames; undefined without a memory.
  torch::Tensor roll(State& state, const torch::Tensor& intention, int64_t frames, const Followed& followed = {});

  torch::nn::GRU encoder{nullptr};         ///< F to h_p (H - Z)
  std::vector<torch::nn::GRUCell> layers;  ///< three; the first sees pose, intention and how far the memory is off
  torch::nn::Conv1d look_ahead{nullptr};   ///< f: labels of gamma frames to intention_features; null without intention
  torch::nn::Linear out{nullptr};          ///< change, then pose: (2 F)
  torch::Tensor pull;                      ///< (F) logit of the weight w
  int64_t intention_features = 0;          ///< channels of f; 0 without intention
  bool memory = false;                     ///< follows one
};
TORCH_MODULE(PoseNetwork);

/// Feed-forward discriminator with `depth` hidden layers: (N, D) flattened input -> (N) logits, above 0 for real.
struct DiscriminatorImpl : torch::nn::Module {
  /// @param inputs D
  DiscriminatorImpl(int64_t inputs, int64_t hidden, int depth);
  /// (N, D) -> (N)
  torch::Tensor forward(const torch::Tensor& x) { return layers->forward(x).squeeze(1); }

  torch::nn::Sequential layers;  ///< linear layers, a nonlinearity behind each but the last
};
TORCH_MODULE(Discriminator);

/// The residual sequence-to-sequence GRU (Martinez et al. 2017): one cell encodes the observation, then feeds on its
/// own predictions. Each is a change that is added to the pose before.
struct Seq2SeqNetworkImpl : torch::nn::Module {
  /// Its size is baselines.seq2seq_hidden.
  explicit Seq2SeqNetworkImpl(const Config& config);
  torch::Tensor forward(const torch::Tensor& past, int64_t frames);  ///< (B, t, F) -> (B, frames, F)

  torch::nn::GRU gru{nullptr};     ///< F to hidden
  torch::nn::Linear out{nullptr};  ///< hidden to a change (F)
};
TORCH_MODULE(Seq2SeqNetwork);

}  // namespace inhabit::anticipate
