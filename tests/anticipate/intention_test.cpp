// Protects the intention labels: which stretches of cluster ids count as cycles, that clustering finds what is there
// and gives the same for the same seed, and that a motion that goes round and round has one label.
#include "inhabit/anticipate/intention.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "inhabit/error.h"
#include "refusal_of.h"

namespace inhabit::anticipate {
namespace {

using torch::Tensor;

/// Segments of a string of cluster ids, one letter a frame.
std::vector<LabelSegment> cycles(const std::string& ids, const CycleOptions& options = {}) {
  return find_cycles({ids.begin(), ids.end()}, options);
}

using Segments = std::vector<LabelSegment>;

TEST(Cycles, ClustersThatDoNotComeBackAreRunsOfTheirOwn) {
  EXPECT_EQ(cycles(""), Segments{});
  EXPECT_EQ(cycles("aaaa"), (Segments{{0, 4, 1}}));
  EXPECT_EQ(cycles("aabbbc"), (Segments{{0, 2, 1}, {2, 5, 1}, {5, 6, 1}}));
  EXPECT_EQ(cycles("aba"), (Segments{{0, 1, 1}, {1, 2, 1}, {2, 3, 1}})) << "seen whole only once";
}

TEST(Cycles, APeriodSeenTwiceIsACycleWhateverItsRunsLengths) {
  EXPECT_EQ(cycles("abab"), (Segments{{0, 4, 2}}));
  EXPECT_EQ(cycles("aabbbabbbb"), (Segments{{0, 10, 2}}));
  EXPECT_EQ(cycles("abcabcab"), (Segments{{0, 8, 3}})) << "the last period need not be whole";
}

TEST(Cycles, StandBetweenSingleRuns) { EXPECT_EQ(cycles("xxabababyy"), (Segments{{0, 2, 1}, {2, 8, 2}, {8, 10, 1}})); }

TEST(Cycles, FollowEachOtherWhereThePeriodChanges) {
  EXPECT_EQ(cycles("abababcdcdcd"), (Segments{{0, 6, 2}, {6, 12, 2}}));
  EXPECT_EQ(cycles("abababcbcbcb"), (Segments{{0, 6, 2}, {6, 12, 2}})) << "one cluster in both";
}

TEST(Cycles, TheLongestStretchWinsAndOfEqualsTheShortestPeriod) {
  EXPECT_EQ(cycles("abababab"), (Segments{{0, 8, 2}})) << "abab twice would do as well";
  EXPECT_EQ(cycles("ababcababc"), (Segments{{0, 10, 5}})) << "ab twice ends after four frames";
}

TEST(Cycles, ARunThatDoesNotFitEndsThem) {
  EXPECT_EQ(cycles("ababababxabababab"), (Segments{{0, 8, 2}, {8, 9, 1}, {9, 17, 2}}));
}

TEST(Cycles, PeriodsMayBeTooLongInRunsOrFrames) {
  EXPECT_EQ(cycles("abcdefabcdef"), (Segments{{0, 12, 6}}));
  EXPECT_EQ(cycles("abcdefgabcdefg").size(), 14U) << "seven runs";
  const std::string slow = std::string(26, 'a') + std::string(25, 'b');
  EXPECT_EQ(cycles(slow + slow).size(), 4U) << "51 frames";
  EXPECT_EQ(cycles(slow.substr(1) + slow.substr(1)), (Segments{{0, 100, 2}})) << "50 frames";
  CycleOptions thrice;
  thrice.repeats = 3;
  EXPECT_EQ(cycles("abab", thrice).size(), 4U);
  EXPECT_EQ(cycles("ababab", thrice), (Segments{{0, 6, 2}}));
}

TEST(Cycles, EveryFrameIsInOneSegment) {
  std::mt19937_64 random(5);
  for (int round = 0; round < 50; ++round) {
    std::string ids;
    for (int i = 0; i < 80; ++i) ids += static_cast<char>('a' + random() % 3);
    int64_t at = 0;
    for (const LabelSegment& segment : cycles(ids)) {
      EXPECT_EQ(segment.first, at) << ids;
      EXPECT_GT(segment.last, at) << ids;
      at = segment.last;
    }
    EXPECT_EQ(at, 80) << ids;
  }
}

/// Points around three places, 60, 30 and 10 of them, shuffled, and to which place each belongs.
struct Clouds {
  Tensor centres = torch::tensor({0.F, 0.F, 8.F, 0.F, 0.F, -8.F}).view({3, 2}), place, points;
  Clouds() {
    torch::manual_seed(7);
    place = torch::cat({torch::zeros({60}), torch::ones({30}), torch::full({10}, 2)})
                .to(torch::kInt64)
                .index({torch::randperm(100)});
    points = centres.index_select(0, place) + 0.3 * torch::randn({100, 2});
  }
};

TEST(Kmeans, FindsWellPartedCloudsLargestFirst) {
  const Clouds clouds;
  for (const uint64_t seed : {1, 2, 3, 4, 5}) {
    const Tensor found = kmeans(clouds.points, 3, seed);
    EXPECT_TRUE(torch::equal(nearest_centre(clouds.points, found), clouds.place)) << seed;
    EXPECT_LT((found - clouds.centres).norm(2, {1}).max().item<double>(), 0.4) << seed;
  }
}

TEST(Kmeans, IsTheSameForTheSameSeed) {
  torch::manual_seed(8);
  const Tensor points = torch::randn({300, 4});  // no clusters: where it begins decides
  EXPECT_TRUE(torch::equal(kmeans(points, 9, 4), kmeans(points, 9, 4)));
  EXPECT_FALSE(torch::equal(kmeans(points, 9, 4), kmeans(points, 9, 5)));
}

TEST(Kmeans, TakesPointsThatAreAllAlikeAndRefusesTooFew) {
  EXPECT_TRUE(torch::isfinite(kmeans(torch::ones({20, 3}), 4, 1)).all().item<bool>());
  EXPECT_THAT(refusal_of([] { kmeans(torch::ones({3, 2}), 4, 1); }), ::testing::HasSubstr("3 poses for 4 clusters"));
  EXPECT_THAT(refusal_of([] { cluster_intentions({}, 2, 4, false, 1); }), ::testing::HasSubstr("no motion"));
}

/// Poses that go back and forth between two places `frames` times, three frames in each, as legs in walking do.
Tensor alternating(int64_t steps, double where) {
  torch::manual_seed(9);
  std::vector<Tensor> out;
  for (int64_t i = 0; i < steps; ++i)
    out.push_back(torch::tensor({where, i % 2 == 0 ? 1.0 : -1.0}, torch::kFloat32).expand({3, 2}));
  return torch::cat(out) + 0.02 * torch::randn({3 * steps, 2});
}

TEST(IntentionLabels, AlternatingPosesAreOneIntentionButNaivelySeveral) {
  const Tensor walk = alternating(12, 10), wipe = alternating(12, -10),
               still = torch::zeros({40, 2}) + torch::tensor({0.F, 30.F}), all = torch::cat({still, walk, wipe});
  const auto distinct = [](const Tensor& labels) {
    const Tensor plain = labels.contiguous();
    return std::set<int64_t>(plain.data_ptr<int64_t>(), plain.data_ptr<int64_t>() + plain.numel());
  };
  const IntentionClusters found = cluster_intentions({all}, 3, 5, false, 1);
  const Tensor labels = intention_labels(all, found);
  EXPECT_EQ(distinct(labels.slice(0, 0, 40)).size(), 1U);
  EXPECT_EQ(distinct(labels.slice(0, 40, 76)).size(), 1U);
  EXPECT_EQ(distinct(labels.slice(0, 76)).size(), 1U);
  EXPECT_EQ(distinct(labels).size(), 3U) << "and each has its own";
  EXPECT_TRUE(torch::equal(labels, intention_labels(all, cluster_intentions({all}, 3, 5, false, 1))));

  const IntentionClusters naive = cluster_intentions({all}, 5, 5, true, 1);
  EXPECT_FALSE(naive.labels.defined());
  const Tensor changes = intention_labels(walk, naive).diff().ne(0);
  EXPECT_EQ(changes.sum().item<int64_t>(), 11) << "at every step";
}

}  // namespace
}  // namespace inhabit::anticipate
