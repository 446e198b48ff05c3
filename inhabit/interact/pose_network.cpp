#include "inhabit/interact/pose_network.h"

#include "inhabit/interact/layout.h"

namespace inhabit::interact {

using torch::Tensor;

FrameSizes frame_sizes(const Config& c) {
  const int64_t keys = c.keys(), future = c.future_points(), joints = c.joints, actions = c.actions;
  FrameSizes s;
  s.pose = 12 * joints + keys * (4 + actions);
  s.goals = keys * (6 + actions);
  s.ego = c.ego_points();
  s.chair = c.chair_size();
  s.control = keys * 2 * 4 + (c.seated_habits ? kAheadSize : 0);
  s.gating = keys * 8 * actions;  // styles times phase, and actions times phase times {1, distance, angle}
  s.outputs = 12 * joints + 3 * joints + future * (4 + actions) + future * 4 + keys * (6 + actions) + 5 + future;
  return s;
}

namespace {

PoseSizes sizes_of(const Config& c, const std::vector<int64_t>& inputs, int64_t gating, int64_t row) {
  PoseSizes s;
  s.inputs = inputs;
  s.encoders.assign(c.encoders.begin(), c.encoders.begin() + static_cast<std::ptrdiff_t>(inputs.size()));
  s.row = row;
  s.gating = gating;
  s.encoder_layers = c.encoder_layers;
  s.experts = c.experts;
  s.hidden = c.hidden;
  s.gating_first = s.gating_second = c.gating_hidden;
  s.outputs = frame_sizes(c).outputs;
  s.dropout = c.training.dropout;
  return s;
}

}  // namespace

PoseSizes pose_sizes(const Config& config) {
  const FrameSizes f = frame_sizes(config);
  return sizes_of(config, {f.pose, f.goals, f.ego, f.chair, f.control}, f.control + f.gating,
                  f.pose + f.goals + f.ego + f.chair + f.control + f.gating);
}

PoseSizes nsm_sizes(const Config& config, bool contacts) {
  FrameSizes f = frame_sizes(config);
  if (contacts) f.goals += kContactInputs;
  return sizes_of(config, {f.pose, f.goals, f.ego, f.chair}, f.gating, f.pose + f.goals + f.ego + f.chair + f.gating);
}

PoseNetworkImpl::PoseNetworkImpl(const PoseSizes& s) : sizes(s) {
  int64_t code = 0;
  for (size_t i = 0; i < s.inputs.size(); ++i) {
    LayerSpec spec;
    spec.widths.assign(static_cast<size_t>(s.encoder_layers) + 1, s.encoders[i]);
    spec.widths.front() = s.inputs[i];
    spec.dropout = s.dropout;
    spec.activate_last = true;
    encoders.push_back(register_module("encoder" + std::to_string(i), make_layers(spec)));
    code += s.encoders[i];
  }
  gating = register_module("gatingNN", GatingNetwork(s.gating, s.gating_first, s.gating_second, s.experts, s.dropout));
  experts = register_module(
      "predNN", ExpertLayers(s.experts, std::vector<int64_t>{code, s.hidden, s.hidden, s.outputs}, s.dropout));
}

Tensor PoseNetworkImpl::gates(const Tensor& x) { return gating(x.narrow(1, sizes.row - sizes.gating, sizes.gating)); }

Tensor PoseNetworkImpl::forward(const Tensor& x) {
  std::vector<Tensor> codes;
  int64_t first = 0;
  for (size_t i = 0; i < encoders.size(); ++i) {
    codes.push_back(encoders[i]->forward(x.narrow(1, first, sizes.inputs[i])));
    first += sizes.inputs[i];
  }
  return experts(torch::cat(codes, 1), gates(x));
}

}  // namespace inhabit::interact
