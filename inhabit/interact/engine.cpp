#include "inhabit/interact/engine.h"

#include <optional>

#include "inhabit/error.h"
#include "inhabit/interact/fast_control_network.h"
#include "inhabit/interact/fast_pose_network.h"
#include "inhabit/math/random.h"

namespace inhabit::interact {
namespace {

const Networks& complete(const Networks& networks, Predictor predictor) {
  const bool there = holds(networks, predictor) && (predictor != Predictor::pose || !networks.control.is_empty());
  if (!there)
    throw Error("interaction", predictor == Predictor::pose ? "the model lacks PoseNet or ControlNet"
                                                            : "the model lacks " + title_of(predictor));
  require_window(networks.config, "interaction");
  return networks;
}

std::vector<float> floats(const torch::Tensor& t) {
  const torch::Tensor plain = t.to(torch::kFloat32).contiguous();
  return {plain.data_ptr<float>(), plain.data_ptr<float>() + plain.numel()};
}

}  // namespace

/// Whichever of them the predictor is.
struct Engine::Fast {
  std::optional<FastPoseNetwork> frame;
  std::optional<FastControlNetwork> control;

  Fast(const interact::Networks& n, Predictor predictor) {
    if (predictor == Predictor::pose) {
      frame.emplace(n.pose);
      control.emplace(n.control);
    } else if (predictor == Predictor::nsm || predictor == Predictor::nsm_control) {
      frame.emplace(predictor == Predictor::nsm ? n.nsm : n.nsm_control);
    }
  }
};

struct Engine::Workspace::Networks {
  FastPoseNetwork::Workspace pose;
  FastControlNetwork::Workspace control;
};

Engine::Engine(const Networks& networks, Predictor predictor)
    : networks_(complete(networks, predictor)),
      predictor_(predictor),
      input_(input_layout(networks.config)),
      output_(output_layout(networks.config)),
      ego_(networks.config),
      fast_(std::make_shared<const Fast>(networks, predictor)),
      input_mean_(floats(networks.input_scale.mean)),
      input_factor_(floats(1 / networks.input_scale.deviation)),
      output_mean_(floats(networks.output_scale.mean)),
      output_factor_(floats(networks.output_scale.deviation)) {}

Engine::Workspace::Workspace(const Engine& engine, uint64_t seed)
    : input(static_cast<size_t>(engine.input_.size)),
      output(static_cast<size_t>(engine.output_.size)),
      memory(engine.controlled() ? static_cast<size_t>(engine.fast_->control->state_size()) : 0),
      random(seed),
      networks(std::make_unique<Networks>()) {
  if (engine.controlled()) engine.start_control(*this);
}

Engine::Workspace::~Workspace() = default;

void Engine::start_control(Workspace& work) const { fast_->control->start(work.memory.data()); }

void Engine::control(const float* pose, const float* control, float* out, Workspace& work) const {
  fast_->control->step(pose, control, 1, work.memory.data(), out, work.networks->control);
}

void Engine::predict_baseline(Workspace& work) const {
  const torch::NoGradGuard no_gradients;
  const torch::Tensor row =
      rows_for(predictor_, input_, torch::from_blob(work.input.data(), {1, input_.size}),
               torch::from_blob(work.contacts.data(), {1, static_cast<int64_t>(work.contacts.size())}))
          .contiguous();
  if (fast_->frame) return fast_->frame->forward(row.data_ptr<float>(), 1, work.output.data(), work.networks->pose);
  SampNetwork samp = predictor_ == Predictor::samp ? networks_.samp : networks_.samp_control;
  torch::Tensor z = torch::empty({1, samp->z});
  for (int64_t i = 0; i < samp->z; ++i) z.data_ptr<float>()[i] = static_cast<float>(normal(work.random));
  torch::from_blob(work.output.data(), {1, output_.size}).copy_(samp->decode(z, row));
}

void Engine::predict(Workspace& work) const {
  for (size_t i = 0; i < work.input.size(); ++i) work.input[i] = (work.input[i] - input_mean_[i]) * input_factor_[i];
  if (predictor_ == Predictor::pose)
    fast_->frame->forward(work.input.data(), 1, work.output.data(), work.networks->pose);
  else
    predict_baseline(work);
  for (size_t i = 0; i < work.output.size(); ++i) work.output[i] = work.output[i] * output_factor_[i] + output_mean_[i];
}

}  // namespace inhabit::interact
