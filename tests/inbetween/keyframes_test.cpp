// Protects what --keyframes, --times and --joints mean: which frames are keys, where they stand, which of the 201
// features a partial key gives, and what is refused.
#include "inhabit/inbetween/keyframes.h"

#include <gmock/gmock.h>

#include "forecast/walker.h"
#include "refusal_of.h"

namespace inhabit::inbetween {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(KeyFrames, EveryNthAndAlwaysTheLast) {
  EXPECT_THAT(key_frames("every:60", 121), ElementsAre(0, 60, 120));
  EXPECT_THAT(key_frames("every:50", 121), ElementsAre(0, 50, 100, 120));
  EXPECT_THAT(key_frames("every:1", 4), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(key_frames("every:9223372036854775807", 5), ElementsAre(0, 4));
}

TEST(KeyFrames, ListIsSortedAndEachOnce) {
  EXPECT_THAT(key_frames("95,30,30,0", 121), ElementsAre(0, 30, 95, 120));
  EXPECT_THAT(key_frames("7", 9), ElementsAre(0, 7, 8));
  EXPECT_THAT(key_frames("ends", 121), ElementsAre(0, 120));
}

TEST(KeyFrames, RandomOnesDependOnTheSeedAlone) {
  EXPECT_EQ(key_frames("random:0.3", 400, 5), key_frames("random:0.3", 400, 5));
  EXPECT_NE(key_frames("random:0.3", 400, 5), key_frames("random:0.3", 400, 6));
  EXPECT_EQ(key_frames("random:1", 20, 3).size(), 20U);
  const std::vector<int64_t> keys = key_frames("random:0.2", 10000, 1);
  EXPECT_NEAR(static_cast<double>(keys.size()), 2000, 160);  // four standard deviations
  EXPECT_EQ(keys.front(), 0);
  EXPECT_EQ(keys.back(), 9999);
  EXPECT_TRUE(std::is_sorted(keys.begin(), keys.end()));
}

TEST(KeyFrames, RefusesWhatGivesNoKeys) {
  const auto refused = [](const std::string& text, int64_t frames = 121) {
    return refusal_of([&] { key_frames(text, frames); });
  };
  EXPECT_THAT(refused("ends", 0), HasSubstr("no two key frames"));
  EXPECT_THAT(refused("every:3", 1), HasSubstr("no two key frames"));
  EXPECT_THAT(refused("every:0"), HasSubstr("at least 1"));
  EXPECT_THAT(refused("every:-5"), HasSubstr("at least 1"));
  EXPECT_THAT(refused("every:2.5"), HasSubstr("whole number"));
  EXPECT_THAT(refused("every:"), HasSubstr("whole number"));
  EXPECT_THAT(refused("0,121"), HasSubstr("frame 121 is outside the clip, whose last frame is 120"));
  EXPECT_THAT(refused("-1"), HasSubstr("outside"));
  for (const char* p : {"random:0", "random:1.01", "random:-0.5", "random:nan", "random:inf"})
    EXPECT_THAT(refused(p), HasSubstr("above 0 and at most 1")) << p;
  EXPECT_THAT(refused("random:half"), HasSubstr("probability"));
  for (const char* text : {"", "0,,5", "1,2,", "first", "99999999999999999999", "3 4", "every"})
    EXPECT_THAT(refused(text), HasSubstr("are none of")) << text;
}

TEST(FramesAtTimes, StandWhereTheyAreWantedAndThePoseBeforeFillsTheRest) {
  const Clip clip = walker(40, 1, 0.5, 1);
  const PosesInTime slow = frames_at_times(clip, {0, 10, 30}, {2, 2.5, 4}, "walk.bvh");
  EXPECT_THAT(slow.keys, ElementsAre(0, 15, 60));
  EXPECT_FALSE(slow.standard) << "on the clip's own skeleton";
  EXPECT_EQ(slow.clip.rate, 30);
  ASSERT_EQ(slow.clip.frames(), 61);
  for (const auto& [at, frame] : {std::pair(0, 0), {14, 0}, {15, 10}, {59, 10}, {60, 30}})
    EXPECT_TRUE(slow.clip.joints[at].allclose(clip.joints[frame], 0, 1e-5)) << at;
  const PosesInTime back = frames_at_times(clip, {30, 0}, {0, 1}, "walk.bvh");
  EXPECT_TRUE(back.clip.joints[0].allclose(clip.joints[30], 0, 1e-5)) << "in the order of the list";
}

TEST(PosesAtTimes, HaveTheirFilesRate) {
  Clip pose = walker(2, 1);
  const auto rate = [&](double a, double b) {
    Clip first = pose, second = pose;
    first.rate = a, second.rate = b;
    const PosesInTime out = poses_at_times({first, second}, {0, 1.5}, 30, {"a.bvh", "b.bvh"});
    EXPECT_EQ(out.keys.back(), std::llround(1.5 * out.clip.rate));
    return out.clip.rate;
  };
  EXPECT_EQ(rate(24, 24), 24);
  EXPECT_EQ(rate(24, 60), 60);
  EXPECT_EQ(rate(1, 1), 30) << "a pose by itself has no rate";
}

TEST(FramesAtTimes, RefuseTimesThatDoNotFit) {
  const Clip clip = walker(40, 1);
  const auto refused = [&](const std::vector<double>& seconds) {
    return refusal_of([&] { frames_at_times(clip, {0, 10}, seconds, "walk.bvh"); });
  };
  EXPECT_THAT(refused({0, 1, 2}), HasSubstr("3 are named for 2 poses"));
  EXPECT_THAT(refused({1, 1.01}), HasSubstr("are not in order, a frame or more apart"));
  EXPECT_THAT(refused({0, 3601}), HasSubstr("more than 55 minutes apart"));
}

TEST(GivenGroups, NameJointsAndTheRootsPath) {
  EXPECT_TRUE(key_groups("").equal(torch::ones({25})));
  torch::Tensor expected = torch::zeros({25});
  expected[0] = 1;  // where the pelvis is, the root is
  expected[kJointGroups] = 1;
  EXPECT_TRUE(key_groups("root").equal(expected));
  EXPECT_TRUE(key_groups("pelvis").equal(expected));
  expected[kJointGroups + 20] = 1;
  EXPECT_TRUE(key_groups("pelvis,left_wrist").equal(expected));
  expected.zero_();
  expected[kJointGroups + 15] = 1;
  EXPECT_TRUE(key_groups("head").equal(expected));
  EXPECT_THAT(refusal_of([] { key_groups("pelvis,tail"); }), HasSubstr("\"tail\" is no joint"));
  EXPECT_THAT(refusal_of([] { key_groups("pelvis,"); }), HasSubstr("\"\" is no joint"));
}

TEST(FeatureMask, SpreadsEachGroupOverItsFeatures) {
  // A value of its own for each group shows up exactly where the group's features are.
  const torch::Tensor mask = feature_mask(torch::arange(25).to(torch::kFloat32).expand({2, 3, 25}));
  ASSERT_EQ(mask.sizes(), (torch::IntArrayRef{2, 3, kFeatureCount}));
  const torch::Tensor one = mask[1][2];
  EXPECT_TRUE(one.slice(0, 0, 3).eq(0).all().item<bool>());
  EXPECT_TRUE(one.slice(0, 3, 9).eq(1).all().item<bool>());
  EXPECT_TRUE(one.slice(0, 9, 135).eq(2).all().item<bool>());
  for (int64_t j = 0; j < 22; ++j)
    EXPECT_TRUE(one.slice(0, 135 + 3 * j, 138 + 3 * j).eq(3 + j).all().item<bool>()) << j;
  EXPECT_EQ(feature_mask(key_groups("root,left_wrist")).sum().item<float>(), 9);
  EXPECT_THAT(refusal_of([] { feature_mask(torch::zeros({24})); }), HasSubstr("(..., 25)"));
}

}  // namespace
}  // namespace inhabit::inbetween
