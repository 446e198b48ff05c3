#pragma once
#include <torch/torch.h>

#include "inhabit/anticipate/config.h"

namespace inhabit::anticipate {

// The networks of the authors' training code (preset "paper"), with its names of parameters. A pose is F numbers.

/// Poses: a GRU over the last observed poses; its code and noise z, joined once, start a decoder of one layer that is
/// warmed up on the last observed frames. It sees the last pose and the labels of gamma frames, and its output is
/// added to that pose.
struct ReleasedPoseNetworkImpl : torch::nn::Module {
  /// @param features F; of `config` hidden, noise, labels, intention_features and gamma are read.
  ReleasedPoseNetworkImpl(const Config& config, int64_t features);

  static constexpr int64_t kPast = 10;   ///< frames that are encoded
  static constexpr int64_t kWarmUp = 3;  ///< of them the last so many, but the very last, warm the decoder up

  /// @param past (B, kPast, F); z (B, Z) normal; labels (B, kPast + frames + gamma - 1, C) of the first observed frame
  /// on. @return (B, frames, F)
  torch::Tensor forward(const torch::Tensor& past, const torch::Tensor& z, const torch::Tensor& labels, int64_t frames);

  torch::nn::GRU encoder{nullptr};        ///< F to hidden
  torch::nn::GRU decoder{nullptr};        ///< pose and intention to hidden + noise
  torch::nn::Conv1d look_ahead{nullptr};  ///< labels of gamma frames to intention_features
  torch::nn::Linear out{nullptr};         ///< hidden + noise to a change (F)
};
TORCH_MODULE(ReleasedPoseNetwork);

/// Labels, 12.5 a second: an encoder and a decoder of three layers, which is fed zeros.
struct ReleasedIntentionNetworkImpl : torch::nn::Module {
  /// @param features F; of `config` intention_hidden and labels are read.
  ReleasedIntentionNetworkImpl(const Config& config, int64_t features);

  static constexpr int64_t kPast = 25;    ///< frames observed, of 12.5 a second
  static constexpr int64_t kFuture = 50;  ///< labels foretold, likewise
  static constexpr int64_t kStride = 2;   ///< frames of 25 a second in one of those

  /// Logits (B, kFuture, C) after poses (B, kPast, F).
  torch::Tensor forward(const torch::Tensor& past);

  torch::nn::GRU encoder{nullptr};  ///< F to intention_hidden, three layers
  torch::nn::GRU decoder{nullptr};  ///< three layers, from the encoder's states
  torch::nn::Linear out{nullptr};   ///< to the logits of C labels
};
TORCH_MODULE(ReleasedIntentionNetwork);

/// What labels are clustered from: three poses of 14 joints at 12.5 Hz in, their code on the unit sphere out. The eight
/// joints of the upper body, the last, are set to zero, so that labels are of the legs.
struct LabelAutoencoderImpl : torch::nn::Module {
  /// @param code numbers of the code
  LabelAutoencoderImpl(int64_t hidden, int64_t code);

  static constexpr int64_t kFrames = 3;   ///< poses that are seen
  static constexpr int64_t kJoints = 14;  ///< joints of a pose
  static constexpr int64_t kLegs = 6;     ///< the first of them, which are seen

  torch::Tensor encode(const torch::Tensor& poses);  ///< (B, 3, 14, 3) -> (B, code)
  torch::Tensor decode(const torch::Tensor& code);   ///< back again

  torch::nn::Sequential encoder;  ///< two linear layers
  torch::nn::Sequential decoder;  ///< two linear layers
};
TORCH_MODULE(LabelAutoencoder);

/// A hidden layer, batch norm, a logit: what judges whole sequences (B, ...) -> (B).
struct SequenceDiscriminatorImpl : torch::nn::Module {
  /// @param inputs numbers of a sequence
  SequenceDiscriminatorImpl(int64_t inputs, int64_t hidden);
  /// (B, ...) -> (B)
  torch::Tensor forward(const torch::Tensor& x) { return layers->forward(x.flatten(1)).squeeze(1); }

  torch::nn::Sequential layers;  ///< linear, ReLU, batch norm, linear
};
TORCH_MODULE(SequenceDiscriminator);

}  // namespace inhabit::anticipate
