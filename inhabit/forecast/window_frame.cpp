#include "inhabit/forecast/window_frame.h"

#include <cmath>

namespace inhabit {

using torch::Tensor;

Tensor WindowFrame::to_window(const Tensor& world) const { return torch::matmul(world - origin, turn.t()); }

Tensor WindowFrame::to_world(const Tensor& window) const { return torch::matmul(window, turn) + origin; }

WindowFrame window_frame(const Tensor& past, const ForecastConfig& config) {
  const Tensor last = past[config.past - 1];
  WindowFrame out{last[config.root].clone(), torch::eye(3)};
  if (!config.hips.empty()) {
    const Tensor left = last[config.hips[0]] - last[config.hips[1]];
    out.turn = yaw_matrix(-std::atan2(-left[2].item<double>(), left[0].item<double>()));
  }
  return out;
}

Tensor yaw_matrix(double yaw) {
  const double c = std::cos(yaw), s = std::sin(yaw);
  return torch::tensor({c, 0., s, 0., 1., 0., -s, 0., c}, torch::kFloat).view({3, 3});
}

}  // namespace inhabit
