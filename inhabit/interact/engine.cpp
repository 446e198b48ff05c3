#include "inhabit/interact/engine.h"

#include "inhabit/error.h"

namespace inhabit::interact {
namespace {

const Networks& complete(const Networks& networks) {
  if (networks.pose.is_empty() || networks.control.is_empty())
    throw Error("interaction", "the model lacks PoseNet or ControlNet");
  require_window(networks.config, "interaction");
  return networks;
}

std::vector<float> floats(const torch::Tensor& t) {
  const torch::Tensor plain = t.to(torch::kFloat32).contiguous();
  return {plain.data_ptr<float>(), plain.data_ptr<float>() + plain.numel()};
}

}  // namespace

Engine::Engine(const Networks& networks)
    : networks_(complete(networks)),
      input_(input_layout(networks.config)),
      output_(output_layout(networks.config)),
      ego_(networks.config),
      pose_(networks.pose),
      control_(networks.control),
      input_mean_(floats(networks.input_scale.mean)),
      input_factor_(floats(1 / networks.input_scale.deviation)),
      output_mean_(floats(networks.output_scale.mean)),
      output_factor_(floats(networks.output_scale.deviation)) {}

Engine::Workspace::Workspace(const Engine& engine)
    : input(static_cast<size_t>(engine.input_.size)),
      output(static_cast<size_t>(engine.output_.size)),
      memory(static_cast<size_t>(engine.control_.state_size())) {
  engine.start_control(*this);
}

void Engine::pose(Workspace& work) const {
  for (size_t i = 0; i < work.input.size(); ++i) work.input[i] = (work.input[i] - input_mean_[i]) * input_factor_[i];
  pose_.forward(work.input.data(), 1, work.output.data(), work.pose);
  for (size_t i = 0; i < work.output.size(); ++i) work.output[i] = work.output[i] * output_factor_[i] + output_mean_[i];
}

}  // namespace inhabit::interact
