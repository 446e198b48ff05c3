#include <gtest/gtest.h>

#include <cmath>

#include "inhabit/error.h"
#include "inhabit/metrics/diversity.h"
#include "inhabit/metrics/ndms.h"
#include "inhabit/metrics/npss.h"
#include "inhabit/motion/canonical.h"

using namespace inhabit;
using torch::Tensor;

namespace {

/// One joint moving by the given steps, (1, kappa, 1, 3).
Tensor word(const std::vector<std::array<float, 3>>& steps) {
  Tensor out = torch::zeros({static_cast<int64_t>(steps.size()) + 1, 3});
  for (size_t i = 0; i < steps.size(); ++i)
    for (int64_t a = 0; a < 3; ++a)
      out[static_cast<int64_t>(i) + 1][a] = out[static_cast<int64_t>(i)][a] + steps[i][static_cast<size_t>(a)];
  return out.view({1, -1, 1, 3});
}

/// Smooth motion of 12 joints, (T, 12, 3), different for each seed.
Tensor swing(int64_t frames, int seed) {
  torch::manual_seed(seed);
  const Tensor t = torch::arange(frames).view({-1, 1, 1}) * 0.2, phase = 6 * torch::rand({1, 12, 3}),
               speed = 0.5 + torch::rand({1, 12, 3});
  return torch::randn({1, 12, 3}) + 0.3 * torch::sin(t * speed + phase);
}

double mean_plausibility(const Tensor& positions, const WordIndex& database) {
  return plausibility(motion_words(positions, 8), database).mean().item<double>();
}

}  // namespace

TEST(Ndms, MatchesHandComputedWords) {
  // Eq. 12: same direction, half the length: 1/2 (1 + 1) 1/2.
  EXPECT_NEAR(ndms(word({{1, 0, 0}}), word({{2, 0, 0}})).item<double>(), 0.5, 1e-9);
  // At a right angle, equal length: 1/2 (1 + 0) 1. Opposite: 0.
  EXPECT_NEAR(ndms(word({{1, 0, 0}}), word({{0, 1, 0}})).item<double>(), 0.5, 1e-9);
  EXPECT_NEAR(ndms(word({{1, 0, 0}}), word({{-1, 0, 0}})).item<double>(), 0, 1e-9);
  // Eq. 11: the mean over steps.
  EXPECT_NEAR(ndms(word({{1, 0, 0}, {1, 0, 0}}), word({{1, 0, 0}, {-1, 0, 0}})).item<double>(), 0.5, 1e-9);
}

TEST(Ndms, TheExactWordScoresOneAndPlantedFaultsLowerIt) {
  const Tensor real = swing(400, 1), seen = real.slice(0, 100, 300);
  const WordIndex database(motion_words(real, 8));
  const double exact = mean_plausibility(seen, database);
  EXPECT_NEAR(exact, 1, 1e-6);
  torch::manual_seed(3);
  const Tensor noise = torch::randn_like(seen), drift = torch::arange(200).view({-1, 1, 1}) * torch::ones({1, 12, 3});
  double before = exact;
  for (const double amount : {0.003, 0.01, 0.03}) {  // more noise, less score
    const double now = mean_plausibility(seen + amount * noise, database);
    EXPECT_LT(now, before) << "noise " << amount;
    before = now;
  }
  before = exact;
  for (const double amount : {0.002, 0.006, 0.02}) {
    const double now = mean_plausibility(seen + amount * drift, database);
    EXPECT_LT(now, before) << "drift " << amount;
    before = now;
  }
  before = exact;
  for (const int64_t frozen : {50, 100, 200}) {  // frames that hold the last pose
    Tensor still = seen.clone();
    still.slice(0, 200 - frozen) = seen[200 - frozen];
    const double now = mean_plausibility(still, database);
    EXPECT_LT(now, before) << "frozen " << frozen;
    before = now;
  }
  before = exact;
  for (const int64_t every : {50, 20, 7}) {  // frames in which everything is somewhere else
    Tensor jumping = seen.clone();
    for (int64_t at = every; at < 200; at += every) jumping[at] += torch::tensor({0.2F, 0.F, 0.1F});
    const double now = mean_plausibility(jumping, database);
    EXPECT_LT(now, before) << "jumps every " << every;
    before = now;
  }
  before = exact;
  for (const int64_t reversed : {50, 100, 200}) {  // frames at the end that run backwards
    Tensor back = seen.clone();
    back.slice(0, 200 - reversed) = seen.slice(0, 200 - reversed).flip(0);
    const double now = mean_plausibility(back, database);
    EXPECT_LT(now, before) << "reversed " << reversed;
    before = now;
  }
  EXPECT_LT(before, 0.8);
  EXPECT_GE(before, 0);
}

TEST(Ndms, AnUnknownWordScoresBelowOneAndTheOrderOfTheDatabaseIsNothing) {
  const Tensor known = motion_words(swing(200, 1), 8), unknown = motion_words(swing(200, 9), 8);
  const Tensor scores = plausibility(unknown, WordIndex(known));
  EXPECT_LT(scores.max().item<double>(), 1);
  EXPECT_GE(scores.min().item<double>(), 0);
  torch::manual_seed(4);
  const Tensor shuffled = plausibility(unknown, WordIndex(known.index({torch::randperm(known.size(0))})));
  EXPECT_LT((shuffled - scores).abs().max().item<double>(), 1e-6);
  EXPECT_THROW(WordIndex(known.slice(0, 0, 0)), Error);
  const Tensor none = motion_words(swing(7, 1), 8);
  EXPECT_EQ(none.size(0), 0) << "shorter than a word";
  EXPECT_EQ(plausibility(none, WordIndex(known)).size(0), 0);
}

TEST(MotionWords, ArePlacedAlikeWhereverThePersonIs) {
  const Tensor words = motion_words(swing(40, 2), 8);
  const double c = std::cos(1.1), s = std::sin(1.1);
  const Tensor turn = torch::tensor({c, 0., s, 0., 1., 0., -s, 0., c}, torch::kFloat).view({3, 3});
  const Tensor moved = torch::matmul(words, turn.t()) + torch::tensor({3.F, 0.F, -2.F});
  const Tensor placed = placed_words(words, 0, 1);
  EXPECT_LT((placed - placed_words(moved, 0, 1)).abs().max().item<double>(), 1e-4);
  const Tensor hips = placed.select(1, 0).slice(1, 0, 2);
  EXPECT_LT((hips.select(1, 0) + hips.select(1, 1)).select(1, 0).abs().max().item<double>(), 1e-5)
      << "middle at the origin";
  EXPECT_LT((hips.select(1, 0) - hips.select(1, 1)).select(1, 2).abs().max().item<double>(), 1e-5) << "line along x";
  EXPECT_GT((hips.select(1, 0) - hips.select(1, 1)).select(1, 0).min().item<double>(), 0) << "left at +x";
}

TEST(WordIndex, FindsWhatADoubleLoopFinds) {
  torch::manual_seed(5);
  // Smooth words, isotropic noise (no leading axes) and repeated words.
  for (const Tensor& words : {motion_words(swing(500, 4), 8).flatten(1), torch::randn({400, 288}),
                              torch::randn({20, 30}).repeat({10, 1}), torch::zeros({5, 9})}) {
    const Tensor queries = torch::cat(
        {words.slice(0, 0, 5),
         words.slice(0, 0, 100) + 0.1 * torch::randn({std::min<int64_t>(100, words.size(0)), words.size(1)})});
    const Tensor squared = (queries.unsqueeze(1) - words.unsqueeze(0)).to(torch::kFloat64).square().sum(2);
    const Tensor found = WordIndex(words).nearest(queries);
    const Tensor mine = squared.gather(1, found.unsqueeze(1)).squeeze(1), best = std::get<0>(squared.min(1));
    EXPECT_LT((mine - best).max().item<double>(), 1e-5);
  }
}

TEST(Npss, IsZeroForEqualAndLargerForMoreDifferentSpectra) {
  const Tensor t = torch::arange(64) * (2 * M_PI / 64);
  const auto wave = [&](double k) { return torch::cos(t * k).view({1, -1, 1}); };
  EXPECT_NEAR(npss(wave(3), wave(3)), 0, 1e-9);
  // All power moves from bins k and 64-k to others: the cumulated shares differ by 1/2 between them, twice.
  EXPECT_NEAR(npss(wave(3), wave(5)), 2 * 0.5 * 2, 1e-6);
  EXPECT_NEAR(npss(wave(3), wave(11)), 2 * 0.5 * 8, 1e-6);
  EXPECT_NEAR(npss(wave(3), 7 * wave(3)), 0, 1e-6) << "power is normalised";
}

TEST(Apd, IsTheMeanDistanceOfPairs) {
  const Tensor samples = torch::tensor({0.F, 0.F, 3.F, 4.F, 0.F, 0.F}).view({3, 1, 2});
  EXPECT_NEAR(average_pairwise_distance(samples)[0].item<double>(), (5 + 5 + 0) / 3.0, 1e-9);
}
