#include "inhabit/interact/contact_network.h"

#include "inhabit/interact/expert_layers.h"

namespace inhabit::interact {

namespace tn = torch::nn;
using torch::Tensor;

namespace {

// Widths of what sees the contacts or z, and the chair's code.
constexpr int64_t kWide = 32, kNarrow = 16;

tn::Sequential relu_layers(const std::vector<int64_t>& widths) {
  LayerSpec spec;
  spec.widths = widths;
  spec.leak = 0;
  return make_layers(spec);
}

}  // namespace

ContactNetworkImpl::ContactNetworkImpl(const Config& c) {
  const auto half = [&](const char* name, const std::vector<int64_t>& widths) {
    auto h = std::make_shared<Half>();
    h->cond_encoder1 = h->register_module(
        "cond_encoder1", relu_layers({c.chair_size(), c.contact_hidden, c.contact_hidden, c.contact_code}));
    h->main = h->register_module("main", relu_layers(widths));
    return register_module(name, h);
  };
  encoder = half("encoder", {kContactPoints + c.contact_code, kWide, kWide, kNarrow});
  encoder->fc1 = encoder->register_module("fc1", tn::Linear(kNarrow, c.contact_z));
  encoder->fc2 = encoder->register_module("fc2", tn::Linear(kNarrow, c.contact_z));
  decoder = half("decoder", {c.contact_z + c.contact_code, kWide, kWide, kNarrow, kContactPoints});
}

nn::LatentDistribution ContactNetworkImpl::encode(const Tensor& contacts, const Tensor& chair) {
  const Tensor code = encoder->main->forward(torch::cat({contacts, encoder->cond_encoder1->forward(chair)}, 1));
  return {encoder->fc1(code), encoder->fc2(code)};
}

Tensor ContactNetworkImpl::decode(const Tensor& z, const Tensor& chair) {
  return decoder->main->forward(torch::cat({z, decoder->cond_encoder1->forward(chair)}, 1));
}

}  // namespace inhabit::interact
