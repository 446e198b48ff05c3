#include "inhabit/interact/expert_layers.h"

#include <cmath>

namespace inhabit::interact {

namespace tn = torch::nn;
using torch::Tensor;

tn::Sequential make_layers(const LayerSpec& spec) {
  tn::Sequential layers;
  for (size_t i = 0; i + 1 < spec.widths.size(); ++i) {
    if (spec.dropout >= 0) layers->push_back(tn::Dropout(spec.dropout));
    layers->push_back(tn::Linear(spec.widths[i], spec.widths[i + 1]));
    if (i + 2 == spec.widths.size() && !spec.activate_last) break;
    if (spec.leak < 0)
      layers->push_back(tn::ELU());
    else
      layers->push_back(tn::LeakyReLU(tn::LeakyReLUOptions().negative_slope(spec.leak)));
  }
  return layers;
}

GatingNetworkImpl::GatingNetworkImpl(int64_t inputs, int64_t first, int64_t second, int64_t experts, double rate)
    : dropout(rate) {
  fc0 = register_module("fc0", tn::Linear(inputs, first));
  fc1 = register_module("fc1", tn::Linear(first, second));
  fc2 = register_module("fc2", tn::Linear(second, experts));
}

Tensor GatingNetworkImpl::forward(const Tensor& x) {
  const auto dropped = [&](const Tensor& t) { return torch::dropout(t, dropout, is_training()); };
  Tensor h = torch::elu(fc0(dropped(x)));
  h = torch::elu(fc1(dropped(h)));
  return torch::softmax(fc2(dropped(h)), 1);
}

ExpertLayersImpl::ExpertLayersImpl(int64_t experts, const std::vector<int64_t>& widths, double rate) : dropout(rate) {
  for (size_t i = 0; i + 1 < widths.size(); ++i) {
    // Averaging experts that know nothing yet shrinks their sum by sqrt(experts): twice a linear layer's variance and
    // more for each makes up for it.
    const double bound = std::sqrt(6.0 / static_cast<double>(widths[i]));
    weights.push_back(register_parameter("expert_weights_fc" + std::to_string(i),
                                         torch::empty({experts, widths[i + 1], widths[i]}).uniform_(-bound, bound)));
    biases.push_back(register_parameter("expert_bias_fc" + std::to_string(i), torch::zeros({experts, widths[i + 1]})));
  }
}

Tensor ExpertLayersImpl::forward(Tensor x, const Tensor& gates) {
  for (size_t i = 0; i < weights.size(); ++i) {
    const Tensor& w = weights[i];
    x = torch::dropout(x, dropout, is_training());
    const Tensor each = x.matmul(w.flatten(0, 1).t()).view({x.size(0), w.size(0), w.size(1)});
    x = torch::bmm(gates.unsqueeze(1), each).squeeze(1) + gates.matmul(biases[i]);
    if (i + 1 < weights.size()) x = torch::elu(x);
  }
  return x;
}

}  // namespace inhabit::interact
