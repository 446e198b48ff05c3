#include <gtest/gtest.h>

#include <cmath>

#include "inhabit/error.h"
#include "inhabit/math/rotation.h"
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

TEST(Ndms, AJointAtRestHasNoMagnitudeInEquation12AndHalfAScoreInThePackage) {
  const Tensor still = word({{0, 0, 0}}), moving = word({{1, 0, 0}});
  EXPECT_EQ(ndms(still, still).item<double>(), 0);
  EXPECT_NEAR(ndms(still, still, NdmsForm::package).item<double>(), 0.5, 1e-9);
  EXPECT_NEAR(ndms(still, moving, NdmsForm::package).item<double>(), 0, 1e-6);
}

TEST(Ndms, SoftLengthsGiveTheScoreOfMotionAndABoundedOneNearRest) {
  torch::manual_seed(1);
  const Tensor words = 0.1 * torch::randn({6, 8, 12, 3}), others = words + 0.05 * torch::randn({6, 8, 12, 3});
  const Tensor soft = ndms(words, others, NdmsForm::equation, 1e-6);
  EXPECT_EQ(soft.scalar_type(), torch::kFloat32);
  EXPECT_TRUE(soft.to(torch::kFloat64).allclose(ndms(words, others), 0, 1e-4));
  // As long as the softness: lengths count as sqrt(2) and sqrt(5) of it, 1/2 (1 + 2 / sqrt(10)) sqrt(2 / 5).
  const double s = 1e-3, expected = 0.5 * (1 + 2 / std::sqrt(10)) * std::sqrt(2 / 5.0);
  EXPECT_NEAR(ndms(word({{1e-3F, 0, 0}}), word({{2e-3F, 0, 0}}), NdmsForm::equation, s).item<double>(), expected, 1e-6);
  // At rest in both words: still nothing; in one of them: nearly a half near rest, nothing of what goes fast.
  const Tensor still = word({{0, 0, 0}});
  EXPECT_EQ(ndms(still, still, NdmsForm::equation, s).item<double>(), 0);
  EXPECT_NEAR(ndms(still, word({{1e-5F, 0, 0}}), NdmsForm::equation, s).item<double>(), 0.5, 1e-3);
  EXPECT_NEAR(ndms(still, word({{1, 0, 0}}), NdmsForm::equation, s).item<double>(), 0, 1e-3);
}

TEST(Ndms, SoftLengthsHaveFiniteGradientsWhereNobodyMoves) {
  torch::manual_seed(2);
  for (const Tensor& others : {torch::rand({2, 8, 12, 3}), torch::zeros({2, 8, 12, 3})}) {
    const Tensor still = torch::zeros({2, 8, 12, 3}).requires_grad_(true);
    ndms(still, others, NdmsForm::equation, 5e-4).sum().backward();
    EXPECT_TRUE(still.grad().isfinite().all().item<bool>());
  }
}

TEST(Ndms, SoftLengthsPassGradientsToTheWordsThatADatabaseIsAskedFor) {
  const WordIndex database(motion_words(swing(200, 6), 8));
  const Tensor walk = swing(40, 5).clone().requires_grad_(true);
  const auto score = [&](const Tensor& motion) {
    return plausibility(motion_words(motion, 8), database, NdmsForm::equation, 5e-4).to(torch::kFloat64).mean();
  };
  score(walk).backward();
  torch::manual_seed(3);
  const Tensor direction = torch::randn({40, 12, 3});
  const torch::NoGradGuard no_gradients;
  const double step = 2e-5,
               change = (score(walk + step * direction) - score(walk - step * direction)).item<double>() / (2 * step);
  EXPECT_NEAR((walk.grad() * direction).sum().item<double>(), change, 0.05 * std::abs(change) + 1e-3);
}

TEST(Ndms, TheAuthorsCodeTakesAlignmentForGrantedWhereVelocitiesDifferInTheNegative) {
  // Half the length at a right angle: 1/2 (1 + 0) 1/2. As coded the cosine is 1 where x - y sums to less than 0.
  const Tensor slow = word({{0, 0.5, 0}}), fast = word({{1, 0, 0}});
  EXPECT_NEAR(ndms(slow, fast).item<double>(), 0.25, 1e-9);
  EXPECT_NEAR(ndms(slow, fast, NdmsForm::coded).item<double>(), 0.5, 1e-9);
  EXPECT_NEAR(ndms(fast, slow, NdmsForm::coded).item<double>(), 0.25, 1e-9);
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
  const Tensor rotation = torch::tensor({c, 0., s, 0., 1., 0., -s, 0., c}, torch::kFloat).view({3, 3});
  const Tensor moved = torch::matmul(words, rotation.t()) + torch::tensor({3.F, 0.F, -2.F});
  const Tensor placed = placed_words(words, 0, 1);
  EXPECT_LT((placed - placed_words(moved, 0, 1)).abs().max().item<double>(), 1e-4);
  const Tensor hips = placed.select(1, 0).slice(1, 0, 2);
  EXPECT_LT((hips.select(1, 0) + hips.select(1, 1)).select(1, 0).abs().max().item<double>(), 1e-5)
      << "middle at the origin";
  EXPECT_LT((hips.select(1, 0) - hips.select(1, 1)).select(1, 2).abs().max().item<double>(), 1e-5) << "line along x";
  EXPECT_GT((hips.select(1, 0) - hips.select(1, 1)).select(1, 0).min().item<double>(), 0) << "left at +x";
}

TEST(PoseWords, KnowNeitherPlaceNorHeadingOfAnyFrame) {
  torch::manual_seed(6);
  const Tensor joints = torch::randn({40, 22, 3});
  const Tensor rotation = yaw_matrix(torch::linspace(0, 9, 40)), path = torch::randn({40, 1, 3});
  const Tensor elsewhere = torch::matmul(joints, rotation.transpose(1, 2)) + path;
  EXPECT_LT((pose_words(elsewhere, 8) - pose_words(joints, 8)).abs().max().item<double>(), 1e-5);
  const Tensor frame = pose_words(joints, 8)[5][0];  // (12, 3)
  EXPECT_NEAR((frame[0] - frame[1])[2].item<double>(), 0, 1e-5) << "the line between the hips along x";
  EXPECT_GT((frame[0] - frame[1])[0].item<double>(), 0) << "the left one at +x";
}

TEST(DatabaseWords, HoldEveryFrameOfTheFasterRecordingAndItsMirrorImage) {
  torch::manual_seed(7);
  const Tensor joints = torch::randn({41, 22, 3});
  const Tensor words = database_words(joints, 8, 2);
  EXPECT_EQ(words.size(0), 2 * (21 - 7 + 20 - 7));
  EXPECT_TRUE(torch::equal(words.slice(0, 0, 14), pose_words(joints.slice(0, 0, c10::nullopt, 2), 8)));
  EXPECT_TRUE(torch::equal(words.slice(0, 14, 27), pose_words(joints.slice(0, 1, c10::nullopt, 2), 8)));
  Tensor seen_in_a_mirror = joints * torch::tensor({-1.F, 1.F, 1.F});
  seen_in_a_mirror = seen_in_a_mirror.index_select(
      1, torch::tensor({0, 2, 1, 3, 5, 4, 6, 8, 7, 9, 11, 10, 12, 14, 13, 15, 17, 16, 19, 18, 21, 20}));
  EXPECT_LT((words.slice(0, 27) - pose_words(seen_in_a_mirror, 8, 2)).abs().max().item<double>(), 1e-5);
  EXPECT_EQ(database_words(joints, 8, 2, WordKind::package).sizes(), (std::vector<int64_t>{14, 8, 16, 3}));
  const Tensor more = database_words(joints, 8, 2, WordKind::dlow);  // spine2, neck and head too
  EXPECT_TRUE(more.narrow(2, 0, 12).equal(words));
  EXPECT_LT((more.slice(0, 0, 14) - words_of(joints.slice(0, 0, c10::nullopt, 2), 8, WordKind::dlow))
                .abs()
                .max()
                .item<double>(),
            1e-5);
  EXPECT_LT(
      (more.slice(0, 27) - torch::cat({words_of(seen_in_a_mirror.slice(0, 0, c10::nullopt, 2), 8, WordKind::dlow),
                                       words_of(seen_in_a_mirror.slice(0, 1, c10::nullopt, 2), 8, WordKind::dlow)}))
          .abs()
          .max()
          .item<double>(),
      1e-5);
  const Tensor one = joints.slice(0, 0, 8), head = words_of(one, 8, WordKind::dlow)[0].select(1, 14);
  EXPECT_LT((head.norm(2, {1}) - (one.select(1, 15) - one.select(1, 0)).norm(2, {1})).abs().max().item<double>(), 1e-5);
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
  // All power moves from bins k and 64-k to others: the cumulated fractions differ by 1/2 between them, twice.
  EXPECT_NEAR(npss(wave(3), wave(5)), 2 * 0.5 * 2, 1e-6);
  EXPECT_NEAR(npss(wave(3), wave(11)), 2 * 0.5 * 8, 1e-6);
  EXPECT_NEAR(npss(wave(3), 7 * wave(3)), 0, 1e-6) << "power is normalised";
}

TEST(Npss, IsOfTheMagnitudeUnlessTheRealPartIsAskedFor) {
  // A wave and the same a quarter of a period later have the same spectrum; its real part alone is gone.
  const Tensor t = torch::arange(64) * (2 * M_PI / 64), slow = torch::cos(3 * t) + torch::cos(9 * t);
  const Tensor a = slow.view({1, -1, 1}), b = (torch::sin(3 * t) + torch::cos(9 * t)).view({1, -1, 1});
  EXPECT_NEAR(npss(a, b), 0, 1e-5);
  EXPECT_GT(npss(a, b, NpssForm::real_part), 1);
}

TEST(Apd, OfWholeFuturesIsThatOfAllFramesInOneVector) {
  const Tensor samples = torch::tensor({0.F, 0.F, 3.F, 4.F}).view({2, 2, 1});
  EXPECT_NEAR(sequence_pairwise_distance(samples), 5, 1e-9);
}

TEST(Apd, IsTheMeanDistanceOfPairs) {
  const Tensor samples = torch::tensor({0.F, 0.F, 3.F, 4.F, 0.F, 0.F}).view({3, 1, 2});
  EXPECT_NEAR(average_pairwise_distance(samples)[0].item<double>(), (5 + 5 + 0) / 3.0, 1e-9);
}
