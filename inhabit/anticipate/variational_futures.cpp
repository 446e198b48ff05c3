#include "inhabit/anticipate/variational_futures.h"

#include <algorithm>
#include <numeric>

#include "inhabit/anticipate/features.h"
#include "inhabit/math/random.h"
#include "inhabit/metrics/forecast_error.h"
#include "inhabit/nn/random_tensor.h"

namespace inhabit::anticipate {

using torch::Tensor;

namespace {

/// (samples, latent), a row of each its own stream.
Tensor drawn_latents(int64_t samples, int64_t latent, uint64_t seed) {
  std::vector<Tensor> rows;
  for (int64_t s = 0; s < samples; ++s) {
    std::mt19937_64 random(item_seed(seed, static_cast<uint64_t>(s)));
    rows.push_back(nn::normal_tensor(random, {latent}));
  }
  return torch::stack(rows);
}

/// @param decode (S, observed, F) and frames -> (S, frames, F), standardised
template <class Decode>
Tensor in_chunks(const Networks& networks, const Tensor& past, int64_t samples, int64_t frames, const Decode& decode) {
  const Config& c = networks.config;
  Tensor all = networks.scale.to_network(past).expand({samples, -1, -1});
  while (all.size(1) < past.size(1) + frames)
    all = torch::cat({all, decode(all.slice(1, std::max<int64_t>(0, all.size(1) - c.observed)), c.future)}, 1);
  return networks.scale.from_network(all.slice(1, past.size(1), past.size(1) + frames));
}

Tensor decoded_by_vae(const Networks& networks, const Tensor& past, const Tensor& z, int64_t frames) {
  MotionVae vae = networks.vae;
  return in_chunks(networks, past, z.size(0), frames, [&](const Tensor& seen, int64_t chunk) {
    return vae->decode(vae->encode(seen), z, seen.select(1, seen.size(1) - 1), chunk);
  });
}

}  // namespace

Tensor vae_futures(const Networks& networks, const Tensor& past, int64_t samples, int64_t frames, uint64_t seed) {
  const torch::NoGradGuard no_gradients;
  return decoded_by_vae(networks, past, drawn_latents(samples, networks.config.baselines.vae_latent, seed), frames);
}

Tensor dlow_futures(const Networks& networks, const Tensor& past, int64_t samples, int64_t frames, uint64_t seed) {
  const torch::NoGradGuard no_gradients;
  LatentSampler sampler = networks.dlow;
  const auto [factor, shift] = sampler->forward(networks.scale.to_network(past));  // (1, K, Z)
  const int64_t draws = (samples + sampler->samples - 1) / sampler->samples;
  const Tensor z = factor * drawn_latents(draws, sampler->latent, seed).unsqueeze(1) + shift;  // (draws, K, Z)
  return decoded_by_vae(networks, past, z.flatten(0, 1).slice(0, 0, samples), frames);
}

Tensor mix_match_futures(const Networks& networks, const Tensor& past, int64_t samples, int64_t frames, uint64_t seed) {
  const torch::NoGradGuard no_gradients;
  const Config& c = networks.config;
  MixMatchNetwork network = networks.mix_match;
  const Tensor z = drawn_latents(samples, c.baselines.mix_latent, seed);
  std::vector<Tensor> places;
  for (int64_t s = 0; s < samples; ++s) {
    std::mt19937_64 random(item_seed(seed ^ 0x706c61636573ULL, static_cast<uint64_t>(s)));
    places.push_back(half_of_places(c.baselines.mix_hidden, random));
  }
  const Tensor taken = torch::stack(places);
  return in_chunks(networks, past, samples, frames, [&](const Tensor& seen, int64_t chunk) {
    return network->decode(network->encode(seen), z, taken, seen.select(1, seen.size(1) - 1), chunk);
  });
}

Tensor grammar_futures(const Networks& networks, const Tensor& past, int64_t samples, int64_t frames, uint64_t seed) {
  const torch::NoGradGuard no_gradients;
  const int64_t rules = networks.config.baselines.grammar_rules;
  GrammarNetwork grammar = networks.grammar;
  std::vector<std::mt19937_64> random;
  for (int64_t s = 0; s < samples; ++s) random.emplace_back(item_seed(seed, static_cast<uint64_t>(s)));
  return in_chunks(networks, past, samples, frames, [&](const Tensor& seen, int64_t chunk) {
    std::vector<Tensor> gumbel;
    for (std::mt19937_64& of_sample : random) gumbel.push_back(nn::gumbel_tensor(of_sample, {chunk, rules}));
    return grammar->produce(grammar->start(seen), torch::stack(gumbel), seen.select(1, seen.size(1) - 1));
  });
}

Tensor half_of_places(int64_t count, std::mt19937_64& random) {
  std::vector<int64_t> order(static_cast<size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  Tensor out = torch::zeros({count});
  for (int64_t k = 0; k < count / 2; ++k) {
    std::swap(order[static_cast<size_t>(k)],
              order[static_cast<size_t>(uniform_int(random, static_cast<int>(k), static_cast<int>(count - 1)))]);
    out[order[static_cast<size_t>(k)]] = 1;
  }
  return out;
}

double nearest_validation_error(const Networks& networks, StochasticFutures method, int64_t futures,
                                const std::vector<Sequence>& sequences) {
  const Config& c = networks.config;
  double sum = 0;
  const std::vector<Cut> windows = test_windows(sequences, c, 32);
  for (size_t w = 0; w < windows.size(); ++w) {
    const Tensor& features = sequences[windows[w].sequence].features;
    const int64_t now = windows[w].now;
    const Tensor past = observation(features, now, c.observed).unsqueeze(0);
    const int64_t known = std::min<int64_t>(static_cast<int64_t>(c.rate), features.size(0) - now);
    const Tensor poses = feature_poses(method(networks, past, futures, known, w));
    const Tensor truth = feature_poses(features.slice(0, now, now + known));
    sum += futures_error(poses, truth).best.mean().item<double>();
  }
  return sum / static_cast<double>(std::max<size_t>(1, windows.size()));
}

}  // namespace inhabit::anticipate
