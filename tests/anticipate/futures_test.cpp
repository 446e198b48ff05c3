// Protects how futures are drawn: the fast decoder gives what the plain networks give, and a future depends on the seed
// and its own number alone, not on how many are drawn or how far.
#include "inhabit/anticipate/futures.h"

#include <gtest/gtest.h>

#include "anticipate/small_networks.h"
#include "inhabit/anticipate/fast_futures.h"
#include "largest.h"

namespace inhabit::anticipate {
namespace {

using torch::Tensor;

/// An observation of each of `count` people (S, t, F).
Tensor pasts(const Config& c, int64_t count) {
  std::vector<Tensor> out;
  for (int64_t i = 0; i < count; ++i)
    out.push_back(joint_features(person(i % 2 == 0 ? "walk" : "wave", c.observed, static_cast<int>(i)).joints));
  return torch::stack(out);
}

/// Weights of some size, so that labels change and poses go somewhere.
Networks lively(const Config& config) {
  const torch::NoGradGuard no_gradients;
  Networks n = untrained(config);
  for (const auto& p : n.pose->named_parameters())
    if (p.key() != "pull") p.value().mul_(1.2);
  if (config.intention)
    for (const Tensor& p : n.intention->parameters()) p.mul_(3);
  return n;
}

/// The fast decoder and the plain networks in double precision: over many frames the rounding of single precision
/// is the larger part of what they differ by.
struct Compared {
  Config config;
  FastFutures fast;
  Networks exact;

  explicit Compared(const Networks& networks) : config(networks.config), fast(networks), exact(networks) {
    if (config.intention) exact.intention->to(torch::kFloat64);
    exact.pose->to(torch::kFloat64);
    exact.scale = {networks.scale.mean.to(torch::kFloat64), networks.scale.deviation.to(torch::kFloat64)};
  }

  void expect_alike(int64_t samples, int64_t frames) const {
    const FutureNoise noise = draw_noise(config, samples, frames, 3);
    for (const int64_t observations : {int64_t{1}, samples}) {
      SCOPED_TRACE(std::to_string(samples) + " samples of " + std::to_string(observations) + " observations, " +
                   std::to_string(frames) + " frames");
      const Tensor past = pasts(config, observations);
      const Futures found = fast.forward(past, noise, frames),
                    expected = plain_futures(
                        exact, past.to(torch::kFloat64),
                        {noise.z.to(torch::kFloat64), noise.gumbel.to(torch::kFloat64), noise.choice}, frames);
      ASSERT_EQ(found.features.sizes(), (torch::IntArrayRef{samples, frames, kFeatureCount}));
      EXPECT_LT(largest(found.features - expected.features), 1e-5);
      ASSERT_EQ(found.labels.defined(), config.intention);
      if (config.intention) {
        EXPECT_TRUE(torch::equal(found.labels, expected.labels));
      }
    }
  }
};

TEST(FastFutures, AreThePlainNetworksFutures) {
  Config c = small_anticipate_config();
  const Compared small(lively(c));
  for (const int64_t samples : {1, 2, 17})
    for (const int64_t frames : {1, 60}) small.expect_alike(samples, frames);
  c.gamma = 1;
  c.noise = 0;
  Compared(lively(c)).expect_alike(3, 20);
  Compared(untrained(Config())).expect_alike(5, 40);  // the sizes that ship
}

TEST(FastFutures, NeedNoIntentionAndNoMemory) {
  for (const bool memory : {true, false})
    for (const bool intention : {true, false}) {
      SCOPED_TRACE((memory ? "memory " : "") + std::string(intention ? "intention" : ""));
      Config c = small_anticipate_config();
      c.memory = memory;
      c.intention = intention;
      const Compared small(lively(c));
      for (const int64_t samples : {1, 6}) small.expect_alike(samples, 30);
    }
}

TEST(FutureNoise, OfASampleIsItsSeedsAlone) {
  const Config c = small_anticipate_config();
  const FutureNoise few = draw_noise(c, 3, 20, 5), many = draw_noise(c, 40, 20, 5), far = draw_noise(c, 3, 70, 5),
                    other = draw_noise(c, 3, 20, 6);
  EXPECT_EQ(few.z.sizes(), (torch::IntArrayRef{3, c.noise}));
  EXPECT_EQ(few.gumbel.sizes(), (torch::IntArrayRef{3, 20 + c.gamma - 1, c.labels}));
  EXPECT_TRUE(torch::equal(few.z, many.z.slice(0, 0, 3)));
  EXPECT_TRUE(torch::equal(few.gumbel, many.gumbel.slice(0, 0, 3)));
  EXPECT_TRUE(torch::equal(few.z, far.z));
  EXPECT_EQ(few.choice.sizes(), (torch::IntArrayRef{3, 20 + c.gamma - 1, 3}));
  EXPECT_TRUE(torch::equal(few.choice, many.choice.slice(0, 0, 3)));
  EXPECT_TRUE(torch::equal(few.choice, far.choice.slice(1, 0, few.choice.size(1))));
  EXPECT_GE(many.choice.min().item<double>(), 0);
  EXPECT_LT(many.choice.max().item<double>(), 1);
  EXPECT_NEAR(many.choice.mean().item<double>(), 0.5, 0.05);
  EXPECT_TRUE(torch::equal(few.gumbel, far.gumbel.slice(1, 0, few.gumbel.size(1))));
  EXPECT_GT(largest(few.z - other.z), 0.1);
  EXPECT_GT(largest(many.z[0] - many.z[1]), 0.1);
  EXPECT_NEAR(many.z.mean().item<double>(), 0, 0.3);
  EXPECT_NEAR(many.z.std().item<double>(), 1, 0.2);
  EXPECT_NEAR(many.gumbel.mean().item<double>(), 0.5772, 0.1);  // Euler's constant
}

TEST(Futures, BeginAlikeHoweverManyAndHoweverFar) {
  const Networks networks = lively(small_anticipate_config());
  const Config& c = networks.config;
  const FastFutures fast(networks);
  const Tensor past = pasts(c, 1);
  const Futures few = fast.forward(past, draw_noise(c, 2, 15, 9), 15),
                many = fast.forward(past, draw_noise(c, 33, 80, 9), 80);
  EXPECT_LT(largest(few.features - many.features.slice(0, 0, 2).slice(1, 0, 15)), 1e-6);
  EXPECT_TRUE(torch::equal(few.labels, many.labels.slice(0, 0, 2).slice(1, 0, 15)));
}

TEST(ComparedFutures, GoOnForAnyHorizon) {
  const Networks networks = untrained();
  const Config& c = networks.config;
  const Tensor past = pasts(c, 3);
  for (const int64_t frames : {1, 6, 7, 30}) {
    for (const BaselineFuture baseline : {seq2seq_future, ltd_future, hisrep_future}) {
      const Tensor future = baseline(networks, past, frames);
      EXPECT_EQ(future.sizes(), (torch::IntArrayRef{3, frames, kFeatureCount}));
      EXPECT_LT(largest(future - baseline(networks, past, 40).slice(1, 0, frames)), 1e-5) << frames;
      EXPECT_TRUE(torch::isfinite(future).all().item<bool>());
    }
  }
}

}  // namespace
}  // namespace inhabit::anticipate
