#include "inhabit/forecast/hypotheses.h"

#include <string>

#include "inhabit/body/skeleton.h"

namespace inhabit::forecast {

namespace tn = torch::nn;
using torch::Tensor;

namespace {

constexpr int kHypothesisBlocks = 2;
constexpr double kApart = 0.02;  // deviation of the last layer's first weights: all begin beside the one forecast

}  // namespace

HypothesesNetworkImpl::HypothesesNetworkImpl(const Config& given) : config(given) {
  const Config::Articulated& a = config.articulated;
  const int64_t width = a.width, count = ArticulatedNetworkImpl::token_count(config), many = a.hypotheses;
  for (int b = 0; b < kHypothesisBlocks; ++b)
    blocks.emplace_back(*this, "block" + std::to_string(b) + "_", count, width);
  out_norm = register_module("out_norm", tn::LayerNorm(tn::LayerNormOptions({width})));
  coefficients = register_module("coefficients", tn::Linear(count, a.coefficients));
  out = register_module("out", tn::Linear(width, many * ArticulatedNetworkImpl::added_count()));
  likely = register_module("likely", tn::Linear(width, many));
  const torch::NoGradGuard no_gradients;
  out->weight.normal_(0, kApart);
  out->bias.zero_();
}

Hypotheses HypothesesNetworkImpl::forward(ArticulatedNetwork network, const ArticulatedNetworkImpl::Seen& seen) {
  const int64_t batch = seen.tokens.size(0), many = config.articulated.hypotheses,
                terms = config.articulated.coefficients;
  Tensor x = seen.tokens;
  for (ArticulatedNetworkImpl::Block& block : blocks) x = block.forward(x, config.training.dropout, is_training());
  x = out_norm->forward(x);
  const Tensor apart = out->forward(coefficients->forward(x.transpose(1, 2)).transpose(1, 2))
                           .view({batch, terms, many, -1})
                           .transpose(1, 2);  // (B, K, coefficients, 105)
  const Tensor added = network->mean_coefficients(seen.tokens).detach().unsqueeze(1) + apart;
  const auto of_each = [&](const Tensor& t) { return t.repeat_interleave(many, 0); };
  const ArticulatedNetworkImpl::Seen each{of_each(seen.past), of_each(seen.path), of_each(seen.rotations), {}};
  const Tensor joints = forecast_joints(network->go_on(each, added.flatten(0, 1)), config.root);
  return {joints.view({batch, many, config.future, kStandardJoints, 3}),
          torch::log_softmax(likely->forward(x.mean(1)), 1)};
}

Tensor hypothesis_errors(const Tensor& joints, const Tensor& last, const Tensor& future, const Config& config) {
  const auto distance = [](const Tensor& apart) { return (apart.square().sum(-1) + 1e-10).sqrt(); };
  const Tensor apart = joints - future.unsqueeze(1), path = apart.select(3, config.root);
  const Tensor others = torch::cat({apart.slice(3, 0, config.root), apart.slice(3, config.root + 1)}, 3);
  const auto steps = [&](const Tensor& all) {  // (B, K, T, J, 3)
    const Tensor before = last.unsqueeze(1).unsqueeze(1).expand({-1, all.size(1), 1, -1, -1});
    return all - torch::cat({before, all.slice(2, 0, all.size(2) - 1)}, 2);
  };
  const Config::Training& t = config.training;
  return t.root_weight * distance(path).mean(2) + t.pose_weight * distance(others - path.unsqueeze(3)).mean({2, 3}) +
         t.velocity_weight * distance(steps(joints) - steps(future.unsqueeze(1))).mean({2, 3});
}

}  // namespace inhabit::forecast
