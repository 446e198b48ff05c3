#pragma once
#include <torch/types.h>

#include "inhabit/forecast/config.h"

namespace inhabit::forecast {

/// The axes the networks see a window in: metres, up +Y, origin at the root of the last observed frame. The release
/// keeps the world's axes; where config.hips names the hip joints, the person faces +Z in that frame instead, so that
/// no weight is spent on learning that people move alike in every direction.
struct WindowFrame {
  torch::Tensor origin;    ///< (3) world
  torch::Tensor rotation;  ///< (3, 3) world axes to the window's

  torch::Tensor to_window(const torch::Tensor& world) const;  ///< (..., 3) positions
  torch::Tensor to_world(const torch::Tensor& window) const;  ///< (..., 3) positions, back
};

/// @param past (P, J, 3) observed joints, world.
WindowFrame window_frame(const torch::Tensor& past, const Config& config);

}  // namespace inhabit::forecast
