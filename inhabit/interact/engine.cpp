#include "inhabit/interact/engine.h"

#include "inhabit/error.h"
#include "inhabit/interact/fast_control_network.h"
#include "inhabit/interact/fast_pose_network.h"

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

struct Engine::Fast {
  FastPoseNetwork pose;
  FastControlNetwork control;
};

struct Engine::Workspace::Networks {
  FastPoseNetwork::Workspace pose;
  FastControlNetwork::Workspace control;
};

Engine::Engine(const Networks& networks)
    : networks_(complete(networks)),
      input_(input_layout(networks.config)),
      output_(output_layout(networks.config)),
      ego_(networks.config),
      fast_(std::make_shared<const Fast>(Fast{FastPoseNetwork(networks.pose), FastControlNetwork(networks.control)})),
      input_mean_(floats(networks.input_scale.mean)),
      input_factor_(floats(1 / networks.input_scale.deviation)),
      output_mean_(floats(networks.output_scale.mean)),
      output_factor_(floats(networks.output_scale.deviation)) {}

Engine::Workspace::Workspace(const Engine& engine)
    : input(static_cast<size_t>(engine.input_.size)),
      output(static_cast<size_t>(engine.output_.size)),
      memory(static_cast<size_t>(engine.fast_->control.state_size())),
      networks(std::make_unique<Networks>()) {
  engine.start_control(*this);
}

Engine::Workspace::~Workspace() = default;

void Engine::start_control(Workspace& work) const { fast_->control.start(work.memory.data()); }

void Engine::control(const float* pose, const float* control, float* out, Workspace& work) const {
  fast_->control.step(pose, control, 1, work.memory.data(), out, work.networks->control);
}

void Engine::pose(Workspace& work) const {
  for (size_t i = 0; i < work.input.size(); ++i) work.input[i] = (work.input[i] - input_mean_[i]) * input_factor_[i];
  fast_->pose.forward(work.input.data(), 1, work.output.data(), work.networks->pose);
  for (size_t i = 0; i < work.output.size(); ++i) work.output[i] = work.output[i] * output_factor_[i] + output_mean_[i];
}

}  // namespace inhabit::interact
