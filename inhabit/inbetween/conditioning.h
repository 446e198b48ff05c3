#pragma once
#include <torch/types.h>

#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/sampler.h"

namespace inhabit::inbetween {

/// What the denoiser is conditioned on, for B windows of T frames.
struct Conditioning {
  GivenFeatures given;      ///< key frames and known frames, standardised (B, 201, T)
  torch::Tensor groups;     ///< (B, T, 25) 1 for what is given of a frame (keyframes.h)
  torch::Tensor occupancy;  ///< (B, 24, 48, 48) of scene_occupancy
  torch::Tensor offsets;    ///< (B, 64, 3, T) metres, basis points of the bodies in key frames; elsewhere not looked at
  torch::Tensor shape;      ///< (B, 7) of body_shape_features
  torch::Tensor detours;    ///< (B, T, 2) metres, of detours_around
};

/// The same as the network takes it.
struct DenoiserInput {
  torch::Tensor mask;      ///< (B, M, T)
  torch::Tensor local;     ///< (B, C, T) embedded offsets and, where the network sees it, the baseline
  torch::Tensor baseline;  ///< (B, 201, T) the keys' interpolation, which the network's output is added to; () zero
                           ///< where it is not
  torch::Tensor scene;     ///< (B, width) embedded occupancy; undefined where the model sees none
  torch::Tensor shape;     ///< (B, width) embedded body shape; zeros where the model sees none
};

/// Makes it, in training as in use. All on the networks' device.
DenoiserInput denoiser_input(const Networks& networks, const Conditioning& conditioning);

}  // namespace inhabit::inbetween
