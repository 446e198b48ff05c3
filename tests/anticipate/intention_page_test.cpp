// Protects the page of `inhabit intentions`: a motion for each label that occurs, and where it is from.
#include "inhabit/anticipate/intention_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "anticipate/people.h"
#include "inhabit/anticipate/features.h"

namespace inhabit::anticipate {
namespace {

using testing::ElementsAre;
using testing::Pair;

TEST(IntentionPage, ShowsAMotionForEachLabelAndWhereItIsFrom) {
  std::vector<Sequence> recordings = {people(40).front(), people(300).back()};
  recordings[1].split = "test";
  IntentionSummary summary;
  summary.tracks = {torch::zeros({40}, torch::kInt64), torch::full({300}, 2, torch::kInt64)};
  summary.labels.resize(3);  // the second does not occur
  summary.labels[0].segments = 1;
  summary.labels[0].actions = {{"walk", 1.0}};
  summary.labels[0].first = 10;
  summary.labels[0].last = 40;
  summary.labels[2].segments = 1;
  summary.labels[2].actions = {{"wave", 0.7}, {"walk", 0.3}};
  summary.labels[2].recording = 1;
  summary.labels[2].first = 20;
  summary.labels[2].last = 300;
  const Skeleton skeleton = person("walk", 2).skeleton;
  const Page page = intention_page(summary, recordings, skeleton, 25, "Intentions of people");

  EXPECT_EQ(page.title, "Intentions of people");
  ASSERT_EQ(page.people.size(), 2U);
  EXPECT_EQ(page.people[0].name, "0 · walk");
  EXPECT_EQ(page.people[0].role, PagePerson::Role::intention);
  EXPECT_EQ(page.people[0].clip.frames(), 30);
  EXPECT_EQ(page.people[0].clip.rate, 25);
  const torch::Tensor shown =
      feature_joints(recordings[0].features.slice(0, 10, 40), torch::zeros({3}), torch::zeros({}));
  EXPECT_TRUE(page.people[0].clip.joints.equal(shown.contiguous()));
  EXPECT_EQ(page.people[1].name, "2 · wave") << "the action that it is most seen in";
  EXPECT_EQ(page.people[1].clip.frames(), 250) << "ten seconds of eleven";
  EXPECT_TRUE(page.people[1].labels.equal(torch::full({250}, 2, torch::kInt64)));

  ASSERT_TRUE(page.recordings.has_value());
  EXPECT_EQ(page.recordings->rate, 25);
  ASSERT_EQ(page.recordings->rows.size(), 2U);
  EXPECT_EQ(page.recordings->rows[0].name, "walk_0");
  EXPECT_EQ(page.recordings->rows[0].group, "walk");
  EXPECT_THAT(page.recordings->rows[0].marked, ElementsAre(Pair(10, 40)));
  EXPECT_EQ(page.recordings->rows[1].name, "wave_1 (test)");
  EXPECT_THAT(page.recordings->rows[1].marked, ElementsAre(Pair(20, 300))) << "all of the segment";
  EXPECT_TRUE(page.recordings->rows[1].labels.equal(summary.tracks[1]));
}

}  // namespace
}  // namespace inhabit::anticipate
