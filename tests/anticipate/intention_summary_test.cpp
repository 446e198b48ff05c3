// Protects what `inhabit intentions` says of labels: fractions, segments, lengths and actions against counts by hand,
// and which segment stands for a label.
#include "inhabit/anticipate/intention_summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace inhabit::anticipate {
namespace {

using testing::HasSubstr;
using torch::Tensor;

/// Frames whose every number is that of `values`.
Sequence recording(const std::string& name, const std::string& action, const std::vector<float>& values) {
  return {name, action, torch::tensor(values).unsqueeze(1).expand({-1, 67}).contiguous()};
}

/// Pose clusters at 0 and 10, which are the labels themselves.
IntentionClusters two_poses() {
  IntentionClusters out;
  out.poses = torch::tensor({{0.F}, {10.F}}).expand({2, 63}).contiguous();
  return out;
}

TEST(IntentionSummary, CountsFramesSegmentsAndActions) {
  const std::vector<Sequence> recordings = {recording("a", "walk", {0, 0, 0, 10, 10}),
                                            recording("b", "jump", {10, 10, 10, 0, 10})};
  const IntentionSummary s = summarise_intentions(recordings, two_poses(), 5);
  ASSERT_EQ(s.labels.size(), 2U);
  EXPECT_NEAR(s.labels[0].fraction, 0.4, 1e-12);
  EXPECT_EQ(s.labels[0].segments, 2);
  EXPECT_NEAR(s.labels[0].seconds, 0.4, 1e-12) << "3 and 1 frames";
  EXPECT_EQ(s.labels[1].segments, 3);
  EXPECT_NEAR(s.labels[1].seconds, 0.4, 1e-12) << "2, 3 and 1";
  ASSERT_EQ(s.labels[1].actions.size(), 2U);
  EXPECT_EQ(s.labels[1].actions[0].first, "jump");
  EXPECT_NEAR(s.labels[1].actions[0].second, 4.0 / 6, 1e-12);
  EXPECT_EQ(s.labels[0].actions[0].first, "walk");
  EXPECT_TRUE(s.tracks[1].equal(torch::tensor({1, 1, 1, 0, 1}, torch::kInt64)));

  EXPECT_THAT(summary_text(s), HasSubstr("    1   60.0%         3     0.40  jump 67%, walk 33%\n"));
  const nlohmann::json rows = summary_json(s, recordings).at("labels");
  EXPECT_EQ(rows[0]["representative"]["recording"], "a");
  EXPECT_EQ(rows[1]["actions"][0]["name"], "jump");
}

TEST(IntentionSummary, TheLongestOfTheNearestQuarterStandsForALabel) {
  // Label 1 has eight segments; the two nearest to its centre, 10, are of one frame (10) and of three (11). The longest
  // of all is far off.
  const std::vector<Sequence> recordings = {
      recording("a", "walk", {10, 0, 14, 14, 14, 14, 0, 13, 0, 13, 0, 13, 0, 12, 0, 12, 12}),
      recording("b", "walk", {0, 0, 11, 11, 11})};
  const LabelSummary label = summarise_intentions(recordings, two_poses(), 5).labels[1];
  EXPECT_EQ(label.segments, 8);
  EXPECT_EQ(label.recording, 1U);
  EXPECT_EQ(label.first, 2);
  EXPECT_EQ(label.last, 5);
}

TEST(IntentionSummary, SegmentsAreComparedByMeanAndDeviation) {
  // Label 1 goes to and fro between the two poses (mean 5, twice the deviation 10); label 0 stays at the first.
  IntentionClusters clusters = two_poses();
  clusters.labels =
      torch::cat({torch::tensor({{0.F}, {5.F}}).expand({2, 63}), torch::tensor({{0.F}, {10.F}}).expand({2, 63})}, 1);
  const std::vector<Sequence> recordings = {recording("uneven", "walk", {0, 10, 10, 0, 10, 10, 0, 10, 10}),
                                            recording("even", "walk", {0, 10, 0, 10, 0, 10}),
                                            recording("still", "stand", {0, 0, 0, 0})};
  const IntentionSummary s = summarise_intentions(recordings, clusters, 5);
  EXPECT_EQ(s.labels[1].segments, 2);
  EXPECT_EQ(s.labels[1].recording, 1U) << "the uneven one is longer and farther from the centre";
  EXPECT_EQ(s.labels[0].recording, 2U);
}

TEST(IntentionSummary, ALabelWithoutFramesIsEmpty) {
  const std::vector<Sequence> recordings = {recording("a", "walk", {0, 0, 0})};
  const IntentionSummary s = summarise_intentions(recordings, two_poses(), 5);
  EXPECT_EQ(s.labels[1].segments, 0);
  EXPECT_EQ(s.labels[1].first, s.labels[1].last);
  EXPECT_FALSE(summary_json(s, recordings)["labels"][1].contains("representative"));
}

}  // namespace
}  // namespace inhabit::anticipate
