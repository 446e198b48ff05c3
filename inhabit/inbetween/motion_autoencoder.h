#pragma once
#include <torch/torch.h>

#include <string>

#include "inhabit/io/safetensors.h"
#include "inhabit/nn/batch_norm.h"
#include "inhabit/train/loop.h"

namespace inhabit::inbetween {

/// Frames of the windows whose features the Frechet distance of in-betweening compares, and how many features there
/// are.
inline constexpr int64_t kFeatureFrames = 121,  ///< frames of a window
    kMotionFeatures = 64;                       ///< features of a window

/// Channels (N, 154, T) of joint windows (N, T, 22, 3), metres, in the canonical frame of the first pose (root above
/// the origin, facing +Z): root position (3), the other joints relative to it (63), every joint's displacement since
/// the frame before (66), and the length of that displacement's change (22); both are 0 before the first frame. The
/// lengths are for jitter: so short a code cannot represent the jitter itself, but its amount.
torch::Tensor motion_channels(const torch::Tensor& joints);

/// Encodes a window of motion as 64 features, and decodes them: what the Frechet distance ("FID") of in-betweening is
/// taken over. 1D convolutions over time, each halving it. Features of the motion it was trained on have mean 0 and
/// deviation 1 each, so that distances can be compared between trainings.
struct MotionAutoencoderImpl : torch::nn::Module {
  MotionAutoencoderImpl();

  torch::Tensor standardised(const torch::Tensor& joints);  ///< (N, 121, 22, 3) -> channels (N, 154, 121)
  torch::Tensor encode(const torch::Tensor& channels);      ///< (N, 154, 121) standardised -> (N, 64)
  torch::Tensor decode(const torch::Tensor& features);      ///< (N, 64) -> (N, 154, 121) standardised

  torch::nn::Sequential encoder;         ///< (N, 154, 121) to (N, 96, 8): four convolutions of stride 2 with SiLU
  torch::nn::Sequential decoder_layers;  ///< (N, 96, 8) to (N, 154, 121): four levels, each about twice as long
  torch::nn::Linear narrow{nullptr};     ///< 768 to 64: what the encoder gives, flat, to features
  torch::nn::Linear widen{nullptr};      ///< 64 to 768: features to what the decoder's layers take
  nn::BatchNorm scale{nullptr};          ///< of the features
  torch::Tensor mean;                    ///< (154) of the training windows' channels
  torch::Tensor deviation;               ///< (154) of the training windows' channels, 0.001 at least
};
TORCH_MODULE(MotionAutoencoder);

/// Features (N, 64) of joint windows (N, 121, 22, 3), metres, in evaluation mode without gradients.
torch::Tensor motion_features(MotionAutoencoder network, const torch::Tensor& joints);

/// What the training loop is told: reconstruct the channels of `train` (N, 121, 22, 3), mean squared error over
/// standardised channels; validated by the same over `validation`. Sets the network's mean and deviation.
TrainTask motion_autoencoder_task(MotionAutoencoder network, const torch::Tensor& train,
                                  const torch::Tensor& validation);

/// Its file without the network (train/stages.h).
SafeTensors motion_autoencoder_header();

/// In evaluation mode. Throws Error naming the file where it is of another kind, or a parameter is missing, of another
/// shape, or not finite.
MotionAutoencoder load_motion_autoencoder(const std::string& path);

}  // namespace inhabit::inbetween
