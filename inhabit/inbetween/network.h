#pragma once
#include <torch/torch.h>

#include "inhabit/inbetween/config.h"
#include "inhabit/inbetween/scene_encoder.h"
#include "inhabit/inbetween/temporal_unet.h"

namespace inhabit::inbetween {

/// The denoiser (3.2): predicts the clean clip from a noisy one, conditioned on key frames, scene, body shape and
/// diffusion step. Parts that the config leaves out have no parameters; their embeddings are zero or empty.
struct DenoiserImpl : torch::nn::Module {
  /// With weights drawn at random by LibTorch's global generator; the last convolution starts at zero.
  explicit DenoiserImpl(const Config& network_config);

  /// c_g, the scene around the first root frame. @param occupancy (B, side / 2, side, side), -1 free or 1 occupied.
  /// @return (B, width); zero in its place is "no scene", for guidance.
  torch::Tensor embed_scene(const torch::Tensor& occupancy);
  /// @param shape (B, 7) body-shape features, of residual motion (B, 21) bone_lengths. @return (B, width)
  torch::Tensor embed_shape(const torch::Tensor& shape);
  /// c_l. @param offsets (B, anchors, 3, T) metres, from each anchor to the scene. @param keys (B, T): the frames that
  /// they are seen at; elsewhere they count as zero. @return (B, 32, T), or (B, 0, T) without local_scene
  torch::Tensor embed_offsets(const torch::Tensor& offsets, const torch::Tensor& keys);

  /// @param x (B, 201, T) standardised features, imputed, T at most `padded`. @param mask (B, M, T) key mask.
  /// @param local from embed_offsets(); with from_interpolation, the interpolated baseline follows in the same
  /// dimension and the output is relative to it. @param steps (B) int64, 0 the cleanest. @param embedding (B, width):
  /// those of scene and shape, summed. @return (B, 201, T), the clean clip
  torch::Tensor forward(const torch::Tensor& x, const torch::Tensor& mask, const torch::Tensor& local,
                        const torch::Tensor& steps, const torch::Tensor& embedding);

  /// Of residual motion: the residual of the clean clip (B, 135, T), divided by its scale.
  /// @param input (B, kResidualChannels, T) of residual_input.h. @param embedding (B, width) of shape
  torch::Tensor residual(const torch::Tensor& input, const torch::Tensor& steps, const torch::Tensor& embedding);
  /// What the residual is read from, (B, C, T): see TemporalUnetImpl::features. Arguments as of residual().
  torch::Tensor features(const torch::Tensor& input, const torch::Tensor& steps, const torch::Tensor& embedding);

  /// Sines and cosines of the step, through two layers: (B, width).
  torch::Tensor embed_steps(const torch::Tensor& steps);

  Config config;                           ///< what the network was made with
  torch::nn::Linear step_in{nullptr};      ///< width to width, on the sines and cosines of the step
  torch::nn::Linear step_out{nullptr};     ///< width to width, after SiLU
  torch::nn::Linear shape_layer{nullptr};  ///< 7, of residual motion 21, to width; empty without body_shape
  /// 3 anchors to 1024, 256, 32 and kLocalChannels, Mish in between; empty without local_scene.
  torch::nn::Linear offset_layers[4]{nullptr, nullptr, nullptr, nullptr};
  SceneEncoder scene_encoder{nullptr};  ///< occupancy to width; empty without global_scene
  torch::nn::Conv1d stem{nullptr};      ///< of residual motion: its many channels become those of the U-Net
  /// The trunk: features, mask and what goes with them to 201 channels; of residual motion width to 135.
  TemporalUnet unet{nullptr};
};
TORCH_MODULE(Denoiser);

}  // namespace inhabit::inbetween
