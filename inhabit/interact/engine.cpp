#include "inhabit/interact/engine.h"

#include <algorithm>

#include "inhabit/error.h"
#include "inhabit/interact/features.h"

namespace inhabit::interact {

Engine::Engine(const Networks& networks)
    : networks_(networks),
      input_(input_layout(networks.config)),
      output_(output_layout(networks.config)),
      ego_(networks.config) {
  if (networks_.pose.is_empty() || networks_.control.is_empty())
    throw Error("interaction", "the model lacks PoseNet or ControlNet");
  require_window(networks_.config, "interaction");
}

void Engine::pose(float* in, float* out) const {
  const torch::NoGradGuard no_gradients;
  const torch::Tensor x = networks_.input_scale.to_network(torch::from_blob(in, {1, input_.size}));
  PoseNetwork network = networks_.pose;
  const torch::Tensor y = networks_.output_scale.from_network(network->forward(x)).contiguous();
  std::copy_n(y.data_ptr<float>(), output_.size, out);
}

void Engine::control(const float* pose, const float* control, ControlState& state, float* out) const {
  const torch::NoGradGuard no_gradients;
  ControlNetwork network = networks_.control;
  if (!state.hidden.defined()) state = network->start(1);
  const auto row = [](const float* p, int64_t size) { return torch::from_blob(const_cast<float*>(p), {1, size}); };
  const torch::Tensor y = network->step(row(pose, kControlPose), row(control, kControlSize), state).contiguous();
  std::copy_n(y.data_ptr<float>(), kControlSize, out);
}

}  // namespace inhabit::interact
