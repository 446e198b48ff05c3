// Protects the scores of anybody's motion: words that were observed do not count, motions weigh by their words, futures
// are compared over what the shortest has, and what cannot be scored is refused by name.
#include "inhabit/metrics/score_motions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "inhabit/error.h"
#include "inhabit/metrics/ndms.h"
#include "inhabit/motion/local_pose.h"
#include "refusal_of.h"

namespace inhabit {
namespace {

using torch::Tensor;

/// A person whose joints swing, each in its own way; the skeleton is the same for every seed.
NamedMotion swinging(const std::string& name, int64_t frames, int seed) {
  torch::manual_seed(7);
  const Tensor rest = torch::randn({1, 22, 3});
  torch::manual_seed(seed);
  const Tensor t = torch::arange(frames).view({-1, 1, 1}) * 0.2;
  return {name, rest + 0.1 * torch::sin(t * (0.5 + torch::rand({1, 22, 3})) + 6 * torch::rand({1, 22, 3}))};
}

TEST(ScoreMotions, NdmsIsTheMeanOverWordsThatHoldAForecast) {
  const std::vector<NamedMotion> known = {swinging("known", 60, 1)}, motions = {swinging("a", 40, 2), known[0]};
  NdmsOptions options;
  options.observed = 20;
  options.reference_stride = 1;
  const NdmsScore score = score_ndms(motions, known, options);
  ASSERT_EQ(score.motions.size(), 2);
  // Words begin at frame 13 at the earliest, so that each holds a frame from 20 on.
  const Tensor words = pose_words(motions[0].joints, 8).slice(0, 13);
  const Tensor expected = plausibility(words, WordIndex(database_words(known[0].joints, 8, 1)));
  EXPECT_EQ(score.reference_words, 2 * (60 - 8 + 1)) << "and the mirror image's";
  EXPECT_GE(score.coded, score.ndms - 1e-9);
  EXPECT_EQ(score.motions[0].words, expected.size(0));
  EXPECT_NEAR(score.motions[0].ndms, expected.mean().item<double>(), 1e-6);
  EXPECT_NEAR(score.motions[1].ndms, 1, 1e-4) << "a motion that the reference holds";
  const auto total = static_cast<double>(score.motions[0].words + score.motions[1].words);
  EXPECT_NEAR(score.ndms,
              (score.motions[0].ndms * score.motions[0].words + score.motions[1].ndms * score.motions[1].words) / total,
              1e-9);
  EXPECT_EQ(score.motions[0].by_second.size(), 1);
  EXPECT_EQ(score.motions[1].by_second.size(), 2);
}

TEST(ScoreMotions, FuturesCountAsLongAsTheShortest) {
  const NamedMotion truth = swinging("truth", 50, 1), same = {"same", truth.joints.slice(0, 0, 30)},
                    other = swinging("other", 40, 2);
  const MotionError error = score_error({same, other}, {truth});
  for (const ErrorByFrame* of : {&error.pose, &error.path, &error.world}) {
    ASSERT_EQ(of->mean.size(0), 30);
    EXPECT_NEAR(of->best_overall, 0, 1e-6);
    EXPECT_GT(of->overall, 0.01);
  }
  EXPECT_EQ(score_apd({same, other}).size(0), 30);
  EXPECT_NEAR(score_npss({same}, {truth}), 0, 1e-6);
}

TEST(ScoreMotions, WhoStandsStillAsTheyWalkIsWrongInTheWorldAlone) {
  NamedMotion still = swinging("still", 50, 1), walks = still;
  walks.joints = still.joints + torch::linspace(0, 2, 50).view({50, 1, 1}) * torch::tensor({1.F, 0.F, 0.F});
  const MotionError error = score_error({still}, {walks});
  EXPECT_NEAR(error.pose.overall, 0, 1e-6);
  EXPECT_NEAR(error.path.overall, 1, 1e-5);
  EXPECT_NEAR(error.world.overall, 1, 1e-5);
  EXPECT_NEAR(error.world.mean[49].item<double>(), 2, 1e-5);
}

TEST(ScoreMotions, WhatCannotBeScoredIsNamed) {
  const NamedMotion shorter = swinging("short.npz", 5, 1), longer = swinging("long.npz", 50, 1);
  const auto refusal = [](const std::function<void()>& run) { return refusal_of(run); };
  EXPECT_THAT(refusal([&] { score_ndms({longer}, {shorter}, {}); }), testing::HasSubstr("short.npz"));
  EXPECT_THAT(refusal([&] { score_ndms({shorter}, {longer}, {}); }), testing::HasSubstr("short.npz"));
  EXPECT_THAT(refusal([&] { score_npss({longer}, {}); }), testing::HasSubstr("one motion for each"));
  EXPECT_THAT(refusal([&] { score_apd({longer}); }), testing::HasSubstr("two futures"));
  EXPECT_THAT(refusal([&] { score_error({longer}, {longer, longer}); }), testing::HasSubstr("long.npz"));
}

}  // namespace
}  // namespace inhabit
