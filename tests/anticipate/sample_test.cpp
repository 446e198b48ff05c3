// Protects what networks are shown: observations of short recordings, where tests look, and training windows with their
// padding, mirror images and labels.
#include "inhabit/anticipate/sample.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "anticipate/small_networks.h"
#include "refusal_of.h"

namespace inhabit::anticipate {
namespace {

using torch::Tensor;

/// Frame t holds t everywhere.
Tensor counted(int64_t frames) { return torch::arange(frames).to(torch::kFloat32).unsqueeze(1).expand({-1, 67}); }

std::vector<int64_t> first_column(const Tensor& rows) {
  const Tensor whole = rows.select(1, 0).to(torch::kInt64).contiguous();
  return {whole.data_ptr<int64_t>(), whole.data_ptr<int64_t>() + whole.numel()};
}

TEST(Observation, IsLeftPaddedWithTheFirstFrame) {
  EXPECT_EQ(first_column(observation(counted(20), 15, 4)), (std::vector<int64_t>{11, 12, 13, 14}));
  EXPECT_EQ(first_column(observation(counted(20), 2, 5)), (std::vector<int64_t>{0, 0, 0, 0, 1}));
  EXPECT_EQ(first_column(observation(counted(20), 20, 3)), (std::vector<int64_t>{17, 18, 19}));
}

TEST(TestWindows, AreSpreadOverAllRecordingsOfAnAction) {
  // 12 frames observed, a second of 25 to come: `now` from 12 to 75 in 100 frames.
  const Config c = small_anticipate_config();
  const std::vector<Sequence> two = {
      {"a", "walk", counted(100)}, {"b", "wave", counted(40)}, {"c", "walk", counted(100)}};
  std::map<size_t, int64_t> count;
  for (const Cut& window : test_windows(two, c, 8)) {
    ++count[window.sequence];
    EXPECT_GE(window.now, c.observed);
    EXPECT_LE(window.now + 25, two[window.sequence].features.size(0));
  }
  EXPECT_EQ(count, (std::map<size_t, int64_t>{{0, 4}, {1, 4}, {2, 4}}))
      << "walk: 4 of each; wave has room for 12 to 15";
  const auto every = test_windows(two, c, 1000);
  EXPECT_EQ(every.size(), 64U + 4U + 64U);
}

TEST(TestWindows, OfShortRecordingsSeeWhatThereIsAndTheShortestAreLeftOut) {
  const Config c = small_anticipate_config();  // kappa 8
  const auto nows = [&](int64_t frames) {
    std::vector<int64_t> out;
    for (const Cut& window : test_windows({{"a", "walk", counted(frames)}}, c, 1000)) out.push_back(window.now);
    return out;
  };
  EXPECT_EQ(nows(37), (std::vector<int64_t>{12}));
  EXPECT_EQ(nows(36).back(), 26) << "less than a second of future: 0.4 s of it";
  EXPECT_EQ(nows(20), (std::vector<int64_t>{10}));
  EXPECT_EQ(nows(18), (std::vector<int64_t>{8}));
  EXPECT_TRUE(nows(17).empty());
  EXPECT_TRUE(nows(1).empty());
}

TEST(AnticipateSequences, AreOfOneSplitOnTheModelsBones) {
  std::vector<ActionMotion> motions;
  for (const char* split : {"train", "test", "train"})
    motions.push_back(
        {"w" + std::to_string(motions.size()), "walk", split, person("walk", 30, static_cast<int>(motions.size()))});
  motions.push_back({"one", "walk", "train", person("walk", 1)});
  EXPECT_TRUE(torch::equal(training_skeleton(motions, "x").offsets, motions[0].clip.skeleton.offsets));
  Skeleton large = builtin_body().skeleton;
  large.offsets = large.offsets * 1.2;
  const auto sequences = sequences_of(motions, "train", large, 25);
  ASSERT_EQ(sequences.size(), 2U) << "one frame has no motion";
  EXPECT_EQ(sequences[1].name, "w2");
  EXPECT_EQ(sequences[1].action, "walk");
  EXPECT_EQ(shown_name(sequences[1]), "w2");
  EXPECT_EQ(shown_name(sequences_of(motions, "test", large, 25).front()), "w1 (test)");
  const Tensor own = joint_features(motions[2].clip.joints);
  EXPECT_TRUE(torch::allclose(sequences[1].features.slice(1, 0, 65), own.slice(1, 0, 65) * 1.2, 1e-3, 1e-4));
  EXPECT_TRUE(torch::allclose(sequences[1].features.select(1, 65), own.select(1, 65), 1e-3, 1e-4)) << "turns are turns";
  EXPECT_THAT(refusal_of([] { training_skeleton({}, "data"); }),
              ::testing::HasSubstr("data: has no training recording"));
}

TEST(Data, WindowsRepeatFramesThatWereNotRecorded) {
  const Networks networks = untrained();  // 12 observed, 16 to come, gamma 4
  const auto recording = people(40)[0];
  const Data data({recording}, networks);
  ASSERT_EQ(data.size(), 40 - 8 - 10 + 1);
  const Tensor all = networks.scale.to_network(recording.features);
  const Tensor labels = intention_labels(intention_poses(recording.features), networks.clusters);

  const auto early = data.sample(0, false);  // the future begins at frame 8
  EXPECT_EQ(early.frames.sizes(), (torch::IntArrayRef{28, kFeatureCount}));
  EXPECT_EQ(early.first, 4);
  EXPECT_EQ(early.last, 28);
  EXPECT_TRUE(torch::equal(early.frames.slice(0, 4), all.slice(0, 0, 24)));
  EXPECT_TRUE(torch::equal(early.frames.slice(0, 0, 4), all.slice(0, 0, 1).expand({4, -1})));
  EXPECT_TRUE(torch::equal(early.labels.slice(0, 4), labels.slice(0, 0, 27)));

  const auto late = data.sample(data.size() - 1, false);  // at frame 30
  EXPECT_EQ(late.first, 0);
  EXPECT_EQ(late.last, 22);
  EXPECT_TRUE(torch::equal(late.frames.slice(0, 0, 22), all.slice(0, 18)));
  EXPECT_TRUE(torch::equal(late.frames.slice(0, 22), all.slice(0, 39).expand({6, -1})));
  EXPECT_EQ(late.labels.size(0), 28 + 3);
  EXPECT_TRUE(torch::equal(late.labels.slice(0, 22), labels.slice(0, 39).expand({9})));
  EXPECT_EQ(late.last_label, 22);
}

TEST(Data, LabelsGoOnBeyondTheFrames) {
  Config config = small_anticipate_config();
  config.training.label_frames = 25;
  const Networks networks = untrained(config);
  const auto recording = people(60)[0];
  const Data data({recording}, networks);
  const Tensor labels = intention_labels(intention_poses(recording.features), networks.clusters);
  const auto early = data.sample(4, false);  // the future begins at frame 12
  EXPECT_EQ(early.last, 28);
  EXPECT_EQ(early.last_label, 37);
  EXPECT_TRUE(torch::equal(early.labels, labels.slice(0, 0, 37)));
  EXPECT_EQ(data.sample(data.size() - 1, false).last_label, 22) << "ten frames before the end";
}

TEST(Data, MirroredWindowsAreThoseOfTheMotionInAMirror) {
  const Networks networks = untrained();
  const auto recording = people(40)[2];  // waves the right arm
  const Data data({recording}, networks);
  const Tensor mirrored = mirrored_features(recording.features);
  const auto window = data.sample(10, true);  // the future begins at frame 18
  EXPECT_TRUE(torch::allclose(window.frames, networks.scale.to_network(mirrored.slice(0, 6, 34)), 0, 1e-6));
  EXPECT_TRUE(
      torch::equal(window.labels, intention_labels(intention_poses(mirrored), networks.clusters).slice(0, 6, 37)));
  EXPECT_FALSE(torch::allclose(window.frames, data.sample(10, false).frames, 0, 0.1));
}

TEST(Data, RareActionsAreShownMoreOften) {
  const Networks networks = untrained();
  const auto long_walk = people(60)[0], wave = people(20)[2], glimpse = people(17)[3];
  // 43 windows of walking; 3 of waving, eight times; none in 17 frames.
  EXPECT_EQ(Data({long_walk, wave}, networks).size(), 43 + 24);
  EXPECT_EQ(Data({long_walk, glimpse}, networks).size(), 43);
}

}  // namespace
}  // namespace inhabit::anticipate
