#include "inhabit/interact/control_network.h"

#include "inhabit/interact/expert_layers.h"

namespace inhabit::interact {

namespace tn = torch::nn;
using torch::Tensor;

ControlNetworkImpl::ControlNetworkImpl(const Config& c) {
  const int64_t wide = c.control_encoder, width = c.control_hidden;
  LayerSpec spec;
  spec.leak = kControlLeak;
  spec.activate_last = true;
  spec.widths = {c.pose_size(), wide, wide};
  encoder1 = register_module("encoder1", make_layers(spec));
  spec.widths = {c.control_size(), wide, wide};
  encoder2 = register_module("encoder2", make_layers(spec));
  rnn = register_module("rnn", tn::LSTM(tn::LSTMOptions(2 * wide, width).num_layers(c.control_layers)));
  fc = register_module("fc", tn::Linear(width, c.control_size()));
  h0 = register_parameter("h0", 0.01 * torch::randn({c.control_layers, 1, width}));
  c0 = register_parameter("c0", 0.01 * torch::randn({c.control_layers, 1, width}));
}

ControlState ControlNetworkImpl::start(int64_t batch) {
  const auto for_all = [&](const Tensor& t) { return t.expand({t.size(0), batch, t.size(2)}).contiguous(); };
  return {for_all(h0), for_all(c0)};
}

Tensor ControlNetworkImpl::forward(const Tensor& pose, const Tensor& control, ControlState& state) {
  const Tensor code = torch::cat({encoder1->forward(pose), encoder2->forward(control)}, 2);
  auto [outputs, last] = rnn->forward(code, std::make_tuple(state.hidden, state.cell));
  state = {std::get<0>(last), std::get<1>(last)};
  return fc(outputs);
}

Tensor ControlNetworkImpl::step(const Tensor& pose, const Tensor& control, ControlState& state) {
  return forward(pose.unsqueeze(0), control.unsqueeze(0), state).squeeze(0);
}

}  // namespace inhabit::interact
