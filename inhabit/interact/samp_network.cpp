#include "inhabit/interact/samp_network.h"

#include "inhabit/interact/pose_network.h"

namespace inhabit::interact {

namespace tn = torch::nn;
using torch::Tensor;

SampNetworkImpl::SampNetworkImpl(const Config& config, bool contacts) {
  const PoseSizes sizes = nsm_sizes(config, contacts);
  const Config::Baselines& b = config.baselines;
  row = sizes.row;
  z = b.samp_z;
  state_ = sizes.inputs[0] + sizes.inputs[1];
  chair_first_ = state_ + sizes.inputs[2];
  chair_ = sizes.inputs[3];
  const int64_t condition = state_ + b.samp_code, half = std::max(1, b.samp_hidden / 2);
  LayerSpec spec;
  spec.widths = {chair_, b.samp_hidden, b.samp_hidden, b.samp_code};
  spec.activate_last = true;
  chair_encoder = register_module("chair_encoder", make_layers(spec));
  spec.widths = {sizes.outputs + condition, b.samp_hidden, half, half};
  state_encoder = register_module("state_encoder", make_layers(spec));
  mean = register_module("mean", tn::Linear(half, z));
  log_variance = register_module("log_variance", tn::Linear(half, z));
  gating = register_module("gating", GatingNetwork(z + condition, b.samp_hidden, b.samp_gating_hidden, b.samp_experts,
                                                   config.training.dropout));
  const std::vector<int64_t> widths = {z + condition, b.samp_hidden, b.samp_hidden, sizes.outputs};
  experts = register_module("experts", ExpertLayers(b.samp_experts, widths, config.training.dropout));
}

Tensor SampNetworkImpl::condition(const Tensor& x) {
  return torch::cat({x.narrow(1, 0, state_), chair_encoder->forward(x.narrow(1, chair_first_, chair_))}, 1);
}

nn::LatentDistribution SampNetworkImpl::encode(const Tensor& next, const Tensor& x) {
  const Tensor code = state_encoder->forward(torch::cat({next, condition(x)}, 1));
  return {mean(code), log_variance(code)};
}

Tensor SampNetworkImpl::decode(const Tensor& drawn, const Tensor& x) {
  const Tensor input = torch::cat({drawn, condition(x)}, 1);
  return experts(input, gating(input));
}

}  // namespace inhabit::interact
