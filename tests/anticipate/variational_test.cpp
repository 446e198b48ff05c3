// Protects the stochastic networks that ours is compared with: their diversity term in closed form,
// what Mix-and-Match takes from where, what a production rule says, gradients to every parameter, and futures of any
// horizon that the seed decides.
#include "inhabit/anticipate/variational_futures.h"

#include <gtest/gtest.h>
#include <torch/csrc/autograd/autograd.h>

#include "anticipate/small_networks.h"
#include "gradients.h"
#include "inhabit/math/random.h"
#include "inhabit/nn/random_tensor.h"
#include "largest.h"

namespace inhabit::anticipate {
namespace {

using torch::Tensor;

TEST(Variational, SamenessIsTheMeanOverPairs) {
  // Three futures at 0, 3 and 4 along one axis: distances 3, 4 and 1.
  const Tensor futures = torch::tensor({0.F, 3.F, 4.F}).view({1, 3, 1});
  const double expected = (std::exp(-9 / 2.0) + std::exp(-16 / 2.0) + std::exp(-1 / 2.0)) / 3;
  EXPECT_NEAR(sameness_of_pairs(futures, 2).item<double>(), expected, 1e-6);
  EXPECT_NEAR(sameness_of_pairs(futures.repeat({5, 1, 1}), 2).item<double>(), expected, 1e-6) << "mean over the batch";
}

TEST(MixMatch, TakesHalfOfTheFuturesCodeAndTheRestOfTheObservations) {
  std::mt19937_64 random(3);
  const Tensor taken = half_of_places(11, random), again = half_of_places(11, random);
  EXPECT_EQ(taken.sum().item<int64_t>(), 5);
  EXPECT_EQ(((taken == 0) | (taken == 1)).sum().item<int64_t>(), 11);
  EXPECT_FALSE(torch::equal(taken, again)) << "other places each time";

  const torch::NoGradGuard no_gradients;
  const Config c = small_anticipate_config();
  torch::manual_seed(1);
  MixMatchNetwork network(c);
  const Tensor code = torch::randn({2, c.baselines.mix_hidden}), future = torch::randn({2, 9, kFeatureCount});
  const Tensor all = torch::ones({c.baselines.mix_hidden}), none = torch::zeros({c.baselines.mix_hidden});
  EXPECT_TRUE(torch::equal(network->posterior(code, future, all).mean, network->posterior(code + 1, future, all).mean));
  EXPECT_TRUE(
      torch::equal(network->posterior(code, future, none).mean, network->posterior(code, future + 1, none).mean));
  const Tensor z = torch::randn({2, c.baselines.mix_latent}), last = torch::randn({2, kFeatureCount});
  EXPECT_TRUE(torch::equal(network->decode(code, z, none, last, 4), network->decode(code, z + 1, none, last, 4)));
  EXPECT_FALSE(torch::equal(network->decode(code, z, all, last, 4), network->decode(code, z + 1, all, last, 4)));
  network->out->weight.zero_();
  network->out->bias.zero_();
  EXPECT_TRUE(torch::equal(network->decode(code, z, all, last, 4), last.unsqueeze(1).expand({-1, 4, -1})))
      << "it predicts changes";
}

TEST(Grammar, TheRuleThatIsDrawnSaysTheChangeAndTheNextNonTerminal) {
  const torch::NoGradGuard no_gradients;
  const Config c = small_anticipate_config();
  const int64_t rules = c.baselines.grammar_rules, frames = 5;
  torch::manual_seed(11);
  GrammarNetwork grammar(c);
  const Tensor start = torch::randn({1, c.baselines.grammar_hidden}), last = torch::randn({1, kFeatureCount});
  // Noise that leaves no doubt: rules 3, 0, 3, 6, 3 are drawn whatever the non-terminals say.
  const std::vector<int64_t> drawn = {3, 0, 3, 6, 3};
  Tensor noise = torch::zeros({1, frames, rules});
  for (int64_t t = 0; t < frames; ++t) noise[0][t][drawn[static_cast<size_t>(t)]] = 1000;
  const Tensor poses = grammar->produce(start, noise, last);
  Tensor pose = last[0];
  for (int64_t t = 0; t < frames; ++t) {
    pose = pose + grammar->terminal->weight.select(1, drawn[static_cast<size_t>(t)]) + grammar->terminal->bias;
    EXPECT_LT(largest(poses[0][t] - pose), 1e-5) << t;
  }
  // What follows a rule depends on the rule alone: another start, the same first rule, the same rest.
  noise.slice(1, 1).zero_();
  const Tensor one = grammar->produce(start, noise, last), other = grammar->produce(start + 1, noise, last);
  EXPECT_LT(largest(one - other), 1e-5);
  noise.zero_();
  EXPECT_GT(largest(grammar->produce(start, noise, last) - grammar->produce(start + 1, noise, last)), 1e-4)
      << "the first rule is drawn by the probabilities that the start gives";
}

TEST(Grammar, DrawsRulesAsOftenAsTheyAreProbable) {
  std::mt19937_64 random(12);
  const Tensor probabilities = torch::tensor({0.1F, 0.6F, 0.3F});
  constexpr int64_t kDraws = 20'000;
  const Tensor drawn = (probabilities.log() + nn::gumbel_tensor(random, {kDraws, 3})).argmax(1);
  for (int64_t rule = 0; rule < 3; ++rule)
    EXPECT_NEAR((drawn == rule).to(torch::kFloat32).mean().item<double>(), probabilities[rule].item<double>(), 0.01);
}

TEST(Variational, GradientsReachEveryParameter) {
  const Config c = small_anticipate_config();
  const Config::Baselines& b = c.baselines;
  torch::manual_seed(2);
  const Tensor past = torch::randn({3, 12, kFeatureCount}), future = torch::randn({3, 9, kFeatureCount}),
               mix = torch::randn({3, 9, kFeatureCount}), last = past.select(1, 11);
  MotionVae vae(c);
  const Tensor code = vae->encode(past);
  const Tensor z = vae->posterior(code, future).sample(torch::randn({3, b.vae_latent}));
  (vae->decode(code, z, last, 9) * mix).sum().backward();
  expect_gradients_everywhere(*vae);

  LatentSampler sampler(c);
  const auto [factor, shift] = sampler->forward(past);
  EXPECT_EQ(factor.sizes(), (torch::IntArrayRef{3, b.dlow_samples, b.vae_latent}));
  EXPECT_EQ(shift.sizes(), factor.sizes());
  (factor * torch::randn(factor.sizes()) + shift).square().sum().backward();
  expect_gradients_everywhere(*sampler);

  MixMatchNetwork network(c);
  std::mt19937_64 random(4);
  const Tensor taken = half_of_places(b.mix_hidden, random), of_past = network->encode(past);
  const Tensor mixed = network->posterior(of_past, future, taken).sample(torch::randn({3, b.mix_latent}));
  (network->decode(of_past, mixed, taken, last, 9) * mix).sum().backward();
  expect_gradients_everywhere(*network);

  GrammarNetwork grammar(c);
  const Tensor gumbel = nn::gumbel_tensor(random, {3, 9, b.grammar_rules});
  (grammar->produce(grammar->start(past), gumbel, last) * mix).sum().backward();
  expect_gradients_everywhere(*grammar);
}

TEST(VariationalFutures, GoOnForAnyHorizonAndTheSeedDecidesThem) {
  const Networks networks = untrained();
  const Config& c = networks.config;
  torch::manual_seed(5);
  const Tensor past = networks.scale.from_network(torch::randn({1, c.observed, kFeatureCount}));
  const int64_t samples = c.baselines.dlow_samples + 2;  // DLow: more than one draw has
  for (const StochasticFutures method : {vae_futures, dlow_futures, mix_match_futures, grammar_futures}) {
    const Tensor all = method(networks, past, samples, 40, 7);
    EXPECT_EQ(all.sizes(), (torch::IntArrayRef{samples, 40, kFeatureCount}));
    EXPECT_TRUE(torch::isfinite(all).all().item<bool>());
    for (const int64_t frames : {int64_t{1}, int64_t{c.future}, int64_t{c.future + 1}})
      EXPECT_LT(largest(method(networks, past, samples, frames, 7) - all.slice(1, 0, frames)), 1e-5) << frames;
    EXPECT_LT(largest(method(networks, past, 2, 40, 7) - all.slice(0, 0, 2)), 1e-5) << "a sample depends on its own";
    EXPECT_GT(largest(method(networks, past, samples, 40, 8) - all), 1e-4);
    for (int64_t s = 1; s < samples; ++s) EXPECT_GT(largest(all[s] - all[0]), 1e-5) << s;
  }
}

}  // namespace
}  // namespace inhabit::anticipate
