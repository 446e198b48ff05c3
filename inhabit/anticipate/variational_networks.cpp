#include "inhabit/anticipate/variational_networks.h"

#include "inhabit/anticipate/network.h"
#include "inhabit/nn/last_state.h"

namespace inhabit::anticipate {

using torch::Tensor;

namespace {

// Widths of the released networks' layers.
constexpr int64_t kWide = 300, kNarrow = 200, kSamplerWide = 1024, kSamplerNarrow = 512;

torch::nn::GRU gru_of(int64_t inputs, int64_t hidden) {
  return torch::nn::GRU(torch::nn::GRUOptions(inputs, hidden).batch_first(true));
}

/// Linear layers, tanh behind each.
torch::nn::Sequential tanh_layers(const std::vector<int64_t>& sizes) {
  torch::nn::Sequential out;
  for (size_t i = 0; i + 1 < sizes.size(); ++i) {
    out->push_back(torch::nn::Linear(sizes[i], sizes[i + 1]));
    out->push_back(torch::nn::Tanh());
  }
  return out;
}

}  // namespace

MotionVaeImpl::MotionVaeImpl(const Config& config) {
  const int64_t hidden = config.baselines.vae_hidden, latent = config.baselines.vae_latent;
  past_encoder = register_module("past_encoder", gru_of(kFeatureCount, hidden));
  future_encoder = register_module("future_encoder", gru_of(kFeatureCount, hidden));
  posterior_layers = register_module("posterior_layers", tanh_layers({2 * hidden, kWide, kNarrow}));
  mean = register_module("mean", torch::nn::Linear(kNarrow, latent));
  log_variance = register_module("log_variance", torch::nn::Linear(kNarrow, latent));
  start = register_module("start", tanh_layers({hidden, kWide, kNarrow, hidden}));
  decoder = register_module("decoder", torch::nn::GRUCell(hidden + latent + kFeatureCount, hidden));
  decoder_layers = register_module("decoder_layers", tanh_layers({hidden, kWide, kNarrow}));
  out = register_module("out", torch::nn::Linear(kNarrow, kFeatureCount));
}

Tensor MotionVaeImpl::encode(const Tensor& past) { return nn::last_state(past_encoder, past); }

nn::LatentDistribution MotionVaeImpl::posterior(const Tensor& code, const Tensor& future) {
  const Tensor both = posterior_layers->forward(torch::cat({code, nn::last_state(future_encoder, future)}, 1));
  return {mean->forward(both), log_variance->forward(both)};
}

Tensor MotionVaeImpl::decode(const Tensor& code, const Tensor& z, const Tensor& last, int64_t frames) {
  const Tensor known = torch::cat({code, z}, 1);
  Tensor state = start->forward(code), pose = last;
  std::vector<Tensor> poses;
  for (int64_t t = 0; t < frames; ++t) {
    state = decoder->forward(torch::cat({known, pose}, 1), state);
    pose = out->forward(decoder_layers->forward(state));
    poses.push_back(pose);
  }
  return torch::stack(poses, 1);
}

LatentSamplerImpl::LatentSamplerImpl(const Config& config)
    : samples(config.baselines.dlow_samples), latent(config.baselines.vae_latent) {
  const int64_t hidden = config.baselines.vae_hidden;
  encoder = register_module("encoder", gru_of(kFeatureCount, hidden));
  layers = register_module("layers", tanh_layers({hidden, kSamplerWide, kSamplerNarrow}));
  factor = register_module("factor", torch::nn::Linear(kSamplerNarrow, samples * latent));
  shift = register_module("shift", torch::nn::Linear(kSamplerNarrow, samples * latent));
}

std::pair<Tensor, Tensor> LatentSamplerImpl::forward(const Tensor& past) {
  const Tensor code = layers->forward(nn::last_state(encoder, past));
  const auto of_samples = [&](torch::nn::Linear& head) { return head->forward(code).view({-1, samples, latent}); };
  return {of_samples(factor), of_samples(shift)};
}

MixMatchNetworkImpl::MixMatchNetworkImpl(const Config& config) {
  const int64_t hidden = config.baselines.mix_hidden, latent = config.baselines.mix_latent;
  past_encoder = register_module("past_encoder", gru_of(kFeatureCount, hidden));
  future_encoder = register_module("future_encoder", gru_of(kFeatureCount, hidden));
  mean = register_module("mean", torch::nn::Linear(hidden, latent));
  log_variance = register_module("log_variance", torch::nn::Linear(hidden, latent));
  from_latent = register_module("from_latent", torch::nn::Linear(latent, hidden));
  decoder = register_module("decoder", torch::nn::GRUCell(kFeatureCount, hidden));
  out = register_module("out", torch::nn::Linear(hidden, kFeatureCount));
}

Tensor MixMatchNetworkImpl::encode(const Tensor& past) { return nn::last_state(past_encoder, past); }

nn::LatentDistribution MixMatchNetworkImpl::posterior(const Tensor& code, const Tensor& future, const Tensor& taken) {
  const Tensor mixed = taken * nn::last_state(future_encoder, future) + (1 - taken) * code;
  return {mean->forward(mixed), log_variance->forward(mixed)};
}

Tensor MixMatchNetworkImpl::decode(const Tensor& code, const Tensor& z, const Tensor& taken, const Tensor& last,
                                   int64_t frames) {
  Tensor state = taken * from_latent->forward(z) + (1 - taken) * code, pose = last;
  std::vector<Tensor> poses;
  for (int64_t t = 0; t < frames; ++t) {
    state = decoder->forward(pose, state);
    pose = pose + out->forward(state);
    poses.push_back(pose);
  }
  return torch::stack(poses, 1);
}

Tensor sameness_of_pairs(const Tensor& futures, double scale) {
  const int64_t count = futures.size(1);
  const Tensor norms = futures.square().sum(2, /*keepdim=*/true);
  const Tensor squares = (norms + norms.transpose(1, 2) - 2 * futures.matmul(futures.transpose(1, 2))).clamp_min(0);
  const Tensor pairs = torch::ones({count, count}, futures.options()).triu(1);
  return ((-squares / scale).exp() * pairs).sum() / (static_cast<double>(futures.size(0)) * pairs.sum());
}

}  // namespace inhabit::anticipate
