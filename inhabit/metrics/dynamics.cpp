#include "inhabit/metrics/dynamics.h"

#include <algorithm>
#include <cmath>

namespace inhabit {

Dynamics dynamics(const Clip& clip, const torch::Tensor& mask) {
  Dynamics out;
  const int64_t T = clip.frames();
  if (T < 4) return out;
  torch::Tensor use = mask.defined() ? mask : torch::ones({T}, torch::kBool);
  use = use.slice(0, 0, T - 3) & use.slice(0, 1, T - 2) & use.slice(0, 2, T - 1) & use.slice(0, 3, T);
  out.frames = use.sum().item<int64_t>();
  if (out.frames == 0) return out;
  auto mean = [&](const torch::Tensor& lengths, int order) {
    return lengths.slice(0, 0, T - 3).index({use}).mean().item<double>() * std::pow(clip.rate, order);
  };
  const torch::Tensor joints = clip.joints.to(torch::kDouble);
  const torch::Tensor ground = joints.select(1, 0).index_select(1, torch::tensor({0, 2}));
  const torch::Tensor velocity = torch::diff(joints, 1, 0), acceleration = torch::diff(velocity, 1, 0);
  out.speed = mean(torch::diff(ground, 1, 0).norm(2, 1), 1);
  out.acceleration = mean(acceleration.norm(2, 2), 2);
  out.jerk = mean(torch::diff(acceleration, 1, 0).norm(2, 2), 3);
  return out;
}

torch::Tensor frames_of_action(const Clip& clip, const std::string& name) {
  const auto it = std::find(clip.action_names.begin(), clip.action_names.end(), name);
  if (!clip.action.defined() || it == clip.action_names.end()) return torch::zeros({clip.frames()}, torch::kBool);
  return clip.action == static_cast<int64_t>(it - clip.action_names.begin());
}

}  // namespace inhabit
