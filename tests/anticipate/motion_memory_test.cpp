// Protects the memory: futures go on in the recording whose motion word is nearest, never in one that is left out, as
// often in each as the probabilities have it, and on in another one where it ends; typical is what others move like.
#include "inhabit/anticipate/motion_memory.h"

#include <gtest/gtest.h>

#include <cmath>

#include "anticipate/small_networks.h"
#include "largest.h"
#include "refusal_of.h"

namespace inhabit::anticipate {
namespace {

using torch::Tensor;

constexpr int64_t kWordFrames = 8, kMean = 25;  // frames of a word; in which the mean fades

/// Recordings of people who tremble, so that no two frames are the same.
std::vector<Remembered> remembered(int64_t frames) {
  torch::manual_seed(1);
  std::vector<Sequence> recordings = people(frames);
  for (Sequence& r : recordings) r.features = r.features + 0.003 * torch::randn_like(r.features);
  return remembered_motion(recordings, kWordFrames);
}

MotionMemory memory_of(int64_t frames, double distance, double stay = 0, double warp = 0) {
  const Networks n = untrained();
  return MotionMemory(remembered(frames), n.clusters, {kWordFrames, distance, 0, 1, stay, warp}, "people");
}

/// What follows on the first `now` frames of recording `number`.
Followed after(const MotionMemory& memory, int64_t number, int64_t now, const Tensor& choice,
               const std::vector<int64_t>& without = {}) {
  const Tensor features = memory.recordings()[static_cast<size_t>(number)].features;
  return memory.follow(features.slice(0, now - kWordFrames, now).unsqueeze(0), choice, without);
}

TEST(MotionMemory, GoesOnInTheRecordingThatItKnows) {
  const MotionMemory memory = memory_of(90, 1e-5);
  for (const int64_t number : {0, 1, 2, 3}) {
    SCOPED_TRACE(number);
    const Tensor features = memory.recordings()[static_cast<size_t>(number)].features;
    const Followed f = after(memory, number, 20, torch::full({1, 60, 3}, 0.5F));
    EXPECT_EQ(f.features.sizes(), (torch::IntArrayRef{1, 60, kFeatureCount}));
    EXPECT_TRUE(torch::equal(f.features[0].slice(0, kMean), features.slice(0, 20 + kMean, 80)));
    EXPECT_LT(
        largest(f.changes[0].slice(0, kMean) - (features.slice(0, 20 + kMean, 80) - features.slice(0, 19 + kMean, 79))),
        1e-7);
    // The mean of the nearest fades into it: never farther from it than they are.
    EXPECT_LT(largest(f.features[0][kMean - 1] - features[20 + kMean - 1]), 1e-2);
  }
}

TEST(MotionMemory, LeavesOutWhatItIsToldTo) {
  const MotionMemory memory = memory_of(90, 1e-5);
  const Tensor own = memory.recordings()[0].features, other = memory.recordings()[1].features;
  const Followed f = after(memory, 0, 20, torch::full({1, 60, 3}, 0.5F), {0});
  EXPECT_GT(largest(f.features[0][40] - own[60]), 1e-4);
  // The other walk, at one of its frames or of its mirror image's.
  double nearest = 1e9;
  for (const Tensor& all : {other, mirrored_features(other)})
    for (int64_t t = 0; t < all.size(0); ++t) nearest = std::min(nearest, largest(f.features[0][40] - all[t]));
  EXPECT_EQ(nearest, 0);
}

TEST(MotionMemory, GoesOnInAnotherPlaceWhereARecordingEnds) {
  const MotionMemory memory = memory_of(60, 1e-5);
  const Followed f = after(memory, 0, 50, torch::rand({1, 400, 3}));
  EXPECT_TRUE(torch::isfinite(f.features).all().item<bool>());
  // Changes are those of the recordings: no leap is among them, where poses may differ by some centimetres.
  const Tensor leaps = (f.features[0].slice(0, 1) - f.features[0].slice(0, 0, -1) - f.changes[0].slice(0, 1)).abs();
  EXPECT_LT(largest(leaps.slice(0, kMean).slice(1, 0, kPoseFeatures)), 0.1);
  EXPECT_LT(largest(f.changes[0].slice(1, 0, kPoseFeatures)), 0.2);
  EXPECT_LT(f.labels.max().item<int64_t>(), untrained().config.labels);
}

TEST(MotionMemory, FollowsSlowerOrFasterAndForSoLong) {
  const MotionMemory memory = memory_of(90, 1e-5, 0, 0.2);
  const Tensor features = memory.recordings()[2].features;
  for (const float u : {0.0F, 0.25F, 1.0F}) {
    SCOPED_TRACE(u);
    Tensor choice = torch::full({1, 45, 3}, 0.5F);
    choice.select(2, 1).fill_(u);
    const Followed f = after(memory, 2, 20, choice);
    const double speed = 0.8 + 0.4 * u;
    for (const int64_t t : {kMean, kMean + 10}) {
      const double frame = 19 + speed * static_cast<double>(t + 1);
      const auto before = static_cast<int64_t>(frame);
      const Tensor expected =
          features[before] + (frame - static_cast<double>(before)) * (features[before + 1] - features[before]);
      EXPECT_LT(largest((f.features[0][t] - expected).slice(0, 0, kPoseFeatures)), 1e-5) << t;
      EXPECT_LT(largest(f.features[0][t].slice(0, 63, 66) - speed * expected.slice(0, 63, 66)), 1e-5) << t;
      EXPECT_LT(largest((f.features[0][t] - f.features[0][t - 1] - f.changes[0][t]).slice(0, 0, kPoseFeatures)),
                t == kMean ? 1e-2 : 1e-5)
          << t;
    }
  }
  // Another is chosen after two seconds where one is followed for so long, and never where the numbers are too high.
  const MotionMemory restless = memory_of(200, 1e-5, 25);
  for (const bool leaves : {true, false}) {
    Tensor choice = torch::full({1, 100, 3}, 0.5F);
    choice.select(2, 2).fill_(leaves ? 0.5F : 1.0F);
    const Followed f = after(restless, 2, 30, choice);
    const Tensor own = restless.recordings()[2].features;
    EXPECT_EQ(largest(f.features[0][40] - own[70]), 0) << "for two seconds at least";
    EXPECT_EQ(largest(f.features[0][90] - own[120]) == 0, !leaves);
  }
}

TEST(MotionMemory, DrawsAsOftenAsTheProbabilitiesHaveIt) {
  // All places are alike but those near the end, where nobody goes on.
  std::vector<Remembered> recordings = remembered(90);
  for (Remembered& r : recordings)
    r.typical = torch::where(torch::arange(90) < 40, torch::zeros({90}), torch::full({90}, -1.F));
  const MotionMemory memory(recordings, untrained().clusters, {kWordFrames, 1e6, 1000}, "people");
  const int64_t count = 4000;
  const Tensor choice =
      torch::arange(count).to(torch::kFloat32).view({count, 1, 1}).expand({count, kMean + 1, 3}) / count;
  const Followed f = after(memory, 0, 20, choice.contiguous());
  std::vector<int64_t> drawn(4);
  for (int64_t s = 0; s < count; ++s)
    for (size_t r = 0; r < 4; ++r) {
      const Tensor own = memory.recordings()[r].features;
      for (const Tensor& all : {own, mirrored_features(own)})
        if (((all - f.features[s][kMean]).abs().amax(1) == 0).any().item<bool>()) {
          ++drawn[r];
          break;
        }
    }
  for (const int64_t times : drawn) EXPECT_NEAR(static_cast<double>(times), count / 4.0, 2);

  // Labels that the intention network gives no chance are not drawn.
  const Tensor past = memory.recordings()[0].features.slice(0, 12, 20).unsqueeze(0);
  for (int64_t label = 0; label < 3; ++label) {
    Tensor scores = torch::full({count, 3}, -1e4F);
    scores.select(1, label).zero_();
    int64_t told = 0;
    const Followed of_label = memory.follow(
        past, choice.slice(1, 0, 2).contiguous(), {}, [&] { return scores; },
        [&](const Tensor& labels) { told += labels.size(0); });
    const bool any = (f.labels.select(1, 0) == label).any().item<bool>();
    if (any) {
      EXPECT_TRUE((of_label.labels.select(1, 0) == label).all().item<bool>()) << label;
    }
    EXPECT_EQ(told, count) << "labels of the first frame, before those of the second";
  }
}

TEST(MotionMemory, PrefersWhatIsTypicalAsFarAsItIsWeighted) {
  std::vector<Remembered> recordings = remembered(60);
  for (size_t i = 0; i < 4; ++i) recordings[i].typical = torch::full({60}, i == 2 ? 0.1F : 0.0F);
  const Networks n = untrained();
  const MotionMemory memory(recordings, n.clusters, {kWordFrames, 1e6, 1000}, "people");
  const Followed f = after(memory, 0, 20, torch::rand({20, kMean + 5, 3}));
  for (int64_t s = 0; s < 20; ++s) {
    const Tensor own = recordings[2].features;
    double nearest = 1e9;
    for (const Tensor& all : {own, mirrored_features(own)})
      for (int64_t t = 0; t < all.size(0); ++t) nearest = std::min(nearest, largest(f.features[s][kMean] - all[t]));
    EXPECT_EQ(nearest, 0) << s;
  }
}

TEST(MotionMemory, NeedsSomethingToRemember) {
  const Networks n = untrained();
  const std::vector<Remembered> brief = {{torch::zeros({12, kFeatureCount}), torch::zeros({12})}};
  EXPECT_EQ(refusal_of([&] {
              MotionMemory(brief, n.clusters, {kWordFrames, 0.01, 0}, "clips");
            }),
            "clips: the recordings are too short to be remembered");
}

TEST(TypicalMotion, IsThatOfMostRecordingsOfAnAction) {
  std::vector<Tensor> features;
  for (int number = 0; number < 4; ++number) features.push_back(people(60)[0].features);  // four times the same
  features.push_back(people(60)[2].features);                                             // and one of something else
  const auto typical = typical_motion(features, {"a", "a", "a", "a", "a"}, kWordFrames);
  ASSERT_EQ(typical.size(), 5U);
  for (const Tensor& t : typical) EXPECT_EQ(t.sizes(), (torch::IntArrayRef{60}));
  for (size_t i = 0; i < 4; ++i)
    EXPECT_GT(typical[i].mean().item<double>(), typical[4].mean().item<double>() + 0.1) << i;
  double sum = 0;
  for (const Tensor& t : typical_motion({features[0], features[4]}, {"a", "b"}, kWordFrames)) sum += largest(t);
  EXPECT_EQ(sum, 0) << "a recording that is alone is neither";
}

}  // namespace
}  // namespace inhabit::anticipate
