#pragma once
#include <torch/types.h>

#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/sampler.h"

namespace inhabit::inbetween {

/// What the denoiser is conditioned on, for B windows of T frames.
struct Conditioning {
  KeyConstraints constraints;  ///< hard constraints: key frames and known frames, standardised (B, 201, T)
  torch::Tensor groups;        ///< (B, T, 25) 1 for the feature groups that are constrained in a frame (keyframes.h)
  torch::Tensor occupancy;     ///< (B, side / 2, side, side) of scene_occupancy
  torch::Tensor offsets;       ///< (B, 64, 3, T) metres, basis points of the bodies in key frames; not read elsewhere
  torch::Tensor shape;         ///< (B, 7) of body_shape_features
  torch::Tensor detours;       ///< (B, T, 2) metres, of detours_around
};

/// The same as the network's input.
struct DenoiserInput {
  torch::Tensor mask;      ///< (B, M, T)
  torch::Tensor local;     ///< (B, C, T) embedded offsets and, where the network sees it, the baseline
  torch::Tensor baseline;  ///< (B, 201, T) interpolated baseline that the network's output is added to; () zero where
                           ///< the network predicts the clip itself
  torch::Tensor scene;     ///< (B, width) embedded occupancy; undefined where the model sees none
  torch::Tensor shape;     ///< (B, width) embedded body shape; zeros where the model sees none
};

/// Makes the input, in training and in use. All on the networks' device.
DenoiserInput denoiser_input(const Networks& networks, const Conditioning& conditioning);

}  // namespace inhabit::inbetween
