#include "inhabit/forecast/window_frame.h"

#include "inhabit/math/rotation.h"

namespace inhabit::forecast {

using torch::Tensor;

Tensor WindowFrame::to_window(const Tensor& world) const { return torch::matmul(world - origin, rotation.t()); }

Tensor WindowFrame::to_world(const Tensor& window) const { return torch::matmul(window, rotation) + origin; }

WindowFrame window_frame(const Tensor& past, const Config& config) {
  const Tensor last = past[config.past - 1];
  WindowFrame out{last[config.root].clone(), torch::eye(3)};
  if (!config.hips.empty()) {
    const Tensor left = last[config.hips[0]] - last[config.hips[1]];
    out.rotation = yaw_matrix(-yaw_of_left(left.to(torch::kDouble)).item<double>());
  }
  return out;
}

}  // namespace inhabit::forecast
