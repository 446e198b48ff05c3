// Protects futures: they go on from where the observed motion ends, on the person's own
// bones, the same for the same seed, and what cannot be forecast is refused in one line.
#include "inhabit/anticipate/intention_anticipator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "anticipate/small_networks.h"
#include "at_once.h"
#include "inhabit/math/rotation.h"
#include "largest.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit::anticipate {
namespace {

using ::testing::HasSubstr;
using torch::Tensor;

/// An untrained model whose decoder changes poses little and is drawn to none.
Networks gentle() {
  const torch::NoGradGuard no_gradients;
  Networks n = untrained();
  n.pose->out->weight.mul_(0.02);
  n.pose->out->bias.zero_();
  n.pose->pull.fill_(-100);
  return n;
}

/// The walker under the names that a .bvh would have.
Clip renamed(Clip clip) {
  clip.skeleton.names = {"Hips",        "LeftUpLeg",    "RightUpLeg",    "Spine",    "LeftLeg",     "RightLeg",
                         "Spine1",      "LeftFoot",     "RightFoot",     "Spine2",   "LeftToeBase", "RightToeBase",
                         "Neck",        "LeftShoulder", "RightShoulder", "Head",     "LeftArm",     "RightArm",
                         "LeftForeArm", "RightForeArm", "LeftHand",      "RightHand"};
  return clip;
}

TEST(IntentionAnticipator, GivesClipsThatAreValidAndLabelled) {
  const IntentionAnticipator anticipator(gentle());
  const Result a = anticipator.run(person("walk", 40), {}, {-1, 4, 1.2, 1, "walk"});
  EXPECT_EQ(a.past.frames(), 12) << "what is observed";
  ASSERT_EQ(a.futures.size(), 4U);
  EXPECT_EQ(a.labels.sizes(), (torch::IntArrayRef{4, 30}));
  EXPECT_GE(a.labels.min().item<int64_t>(), 0);
  EXPECT_LT(a.labels.max().item<int64_t>(), 3);
  for (const Clip& future : a.futures) {
    EXPECT_NO_THROW(validate(future, "future"));
    EXPECT_EQ(future.frames(), 30);
    EXPECT_EQ(future.rate, 25);
    EXPECT_EQ(future.rotations.sizes(), (torch::IntArrayRef{30, 22, 3}));
  }
  EXPECT_GT(largest(a.futures[0].joints - a.futures[1].joints), 1e-4);
}

TEST(IntentionAnticipator, ServesSeveralThreadsAtOnce) {
  const IntentionAnticipator anticipator(gentle());
  const Clip clip = person("walk", 40);
  const auto run = [&] { return anticipator.run(clip, {}, {-1, 3, 1.2, 1, "walk"}).futures; };
  const std::vector<Clip> expected = run();
  for (const std::vector<Clip>& found : at_once(4, run))
    for (size_t i = 0; i < expected.size(); ++i)
      EXPECT_LT(largest_difference(found[i].joints, expected[i].joints), 1e-5) << i;
}

TEST(IntentionAnticipator, FuturesBeginWhereThePastEnds) {
  const IntentionAnticipator anticipator(gentle());
  for (const char* action : {"walk", "wave"}) {
    const Result a = anticipator.run(person(action, 40, 1), {}, {-1, 3, 1, 1, action});
    const Tensor past = a.past.joints;
    const double quickest = (past.slice(0, 1) - past.slice(0, 0, -1)).norm(2, {2}).max().item<double>();
    for (const Clip& future : a.futures) {
      // No joint steps further than ever before by more than the fit of joint angles leaves.
      EXPECT_LT((future.joints[0] - past[-1]).norm(2, {1}).max().item<double>(), quickest + 0.03) << action;
      EXPECT_LT((future.joints[0][0] - past[-1][0]).norm().item<double>(), 0.06) << action;
      const Tensor steps = (future.joints.slice(0, 1) - future.joints.slice(0, 0, -1)).norm(2, {2});
      EXPECT_LT(steps.max().item<double>(), quickest + 0.06) << action;
    }
  }
  // The walker goes on at 1 m/s: what nothing is added to keeps its step.
  const Result a = anticipator.run(person("walk", 40), {}, {-1, 2, 1, 1, "walk"});
  const Tensor path = a.futures[0].root_path();
  EXPECT_NEAR((path[-1] - path[0]).norm().item<double>(), 24 * 1.2 / 30, 0.3);
}

TEST(IntentionAnticipator, HeadAndWristsAreHeldAsTheyWere) {
  Clip clip = person("walk", 40);
  for (const int64_t joint : {15, 20, 21}) clip.rotations.select(1, joint).select(1, 0).fill_(0.7);  // moves no joint
  for (const Clip& future : IntentionAnticipator(gentle()).run(clip, {}, {-1, 3, 1, 1, "walk"}).futures)
    for (const int64_t joint : {15, 20, 21})
      EXPECT_LT(largest(future.rotations[0][joint] - clip.rotations[39][joint]), 0.1) << joint;
}

TEST(IntentionAnticipator, IsTheSameForTheSameSeedHoweverManyAreDrawn) {
  const IntentionAnticipator anticipator(untrained());
  const Clip clip = person("walk", 30);
  const Result few = anticipator.run(clip, {}, {-1, 2, 0.8, 7, "walk"}),
               again = anticipator.run(clip, {}, {-1, 2, 0.8, 7, "walk"}),
               many = anticipator.run(clip, {}, {-1, 9, 0.8, 7, "walk"}),
               other = anticipator.run(clip, {}, {-1, 2, 0.8, 8, "walk"});
  for (size_t s = 0; s < 2; ++s) {
    EXPECT_TRUE(torch::equal(few.futures[s].joints, again.futures[s].joints));
    EXPECT_TRUE(torch::equal(few.futures[s].rotations, again.futures[s].rotations));
    EXPECT_LT(largest(few.futures[s].joints - many.futures[s].joints), 1e-4);
    EXPECT_GT(largest(few.futures[s].joints - other.futures[s].joints), 1e-3);
  }
  EXPECT_TRUE(torch::equal(few.labels, many.labels.slice(0, 0, 2)));
}

TEST(IntentionAnticipator, StartIsTheFirstForecastFrameOfTheClip) {
  const IntentionAnticipator anticipator(gentle());
  const Clip clip = person("walk", 60);
  const Result early = anticipator.run(clip, {}, {20, 1, 0.4, 1, "walk"}),
               cut = anticipator.run(slice(clip, 0, 20), {}, {-1, 1, 0.4, 1, "walk"});
  EXPECT_TRUE(torch::equal(early.futures[0].joints, cut.futures[0].joints));
  EXPECT_LT(largest(early.past.joints - clip.joints.slice(0, 8, 20)), 1e-4);
  Clip quick = clip;  // the same frames, called 50 a second
  quick.rate = 50;
  const Result half = anticipator.run(quick, {}, {40, 1, 0.4, 1, "walk"});
  EXPECT_EQ(half.past.rate, 25);
  EXPECT_LT(largest(half.past.joints[-1] - clip.joints[39]), 1e-3);
}

TEST(IntentionAnticipator, MovesAlongWithTheWorld) {
  const IntentionAnticipator anticipator(gentle());
  Clip clip = person("walk", 30);
  const Result before = anticipator.run(clip, {}, {-1, 1, 1, 3, "walk"});
  const Tensor rotation = yaw_matrix(1.3), shift = torch::tensor({4.F, 0.F, -2.F});
  clip.rotations = clip.rotations.clone();
  clip.rotations.select(1, 0).copy_(
      matrix_to_axis_angle(torch::matmul(rotation, axis_angle_to_matrix(clip.rotations.select(1, 0)))));
  const Tensor rest = clip.skeleton.offsets[0];
  clip.trans = torch::matmul(clip.trans + rest, rotation.t()) + shift - rest;
  clip.joints = torch::matmul(clip.joints, rotation.t()) + shift;
  const Result after = anticipator.run(clip, {}, {-1, 1, 1, 3, "walk"});
  EXPECT_LT(largest(after.futures[0].joints - (torch::matmul(before.futures[0].joints, rotation.t()) + shift)), 5e-3);
}

TEST(IntentionAnticipator, OtherSkeletonsKeepTheirBones) {
  const IntentionAnticipator anticipator(gentle());
  Clip clip = renamed(person("walk", 30));
  clip.skeleton.offsets = clip.skeleton.offsets * 0.8;  // a child
  clip.trans = clip.trans * 0.8;
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  const Result a = anticipator.run(clip, {}, {-1, 2, 1, 1, "walk.bvh"});
  for (const Clip& future : a.futures) {
    EXPECT_EQ(future.skeleton.names, standard_joint_names());
    for (const int64_t knee : {4, 5})
      EXPECT_NEAR(
          (future.joints.select(1, knee) - future.joints.select(1, knee - 3)).norm(2, {1}).mean().item<double>(),
          clip.skeleton.offsets[knee].norm().item<double>(), 5e-3);
    EXPECT_LT((future.joints[0] - a.past.joints[-1]).norm(2, {1}).mean().item<double>(), 0.08);
  }
  Clip car = clip;
  for (std::string& name : car.skeleton.names) name = "wheel_" + name.substr(0, 2);
  EXPECT_THAT(refusal_of([&] { anticipator.run(car, {}, {-1, 10, 4, 1, "car.bvh"}); }), HasSubstr("car.bvh: "));
}

TEST(IntentionAnticipator, RefusesTooShortAnObservationAndBadNumbers) {
  const IntentionAnticipator anticipator(gentle());
  const Clip clip = person("walk", 30);
  const auto refusal = [&](const Clip& observed, int64_t start) {
    return refusal_of([&] { anticipator.run(observed, {}, {start, 1, 0.4, 1, "walk.bvh"}); });
  };
  EXPECT_EQ(refusal(clip, 8), "") << "kappa frames will do";
  EXPECT_THAT(refusal(clip, 7), HasSubstr("walk.bvh: has 7 frames"));
  EXPECT_THAT(refusal(clip, 7), HasSubstr("at least 8 are needed"));
  EXPECT_THAT(refusal(clip, 0), HasSubstr("has 0 frames"));
  EXPECT_THAT(refusal(clip, 31), HasSubstr("frame 31 is beyond the end (30 frames)"));
  EXPECT_THAT(refusal(slice(clip, 0, 5), -1), HasSubstr("has 5 frames"));
  EXPECT_EQ(refusal(clip, -2), "start: is under 0");
  for (const int64_t samples : {0, 100'001})
    EXPECT_THAT(refusal_of([&] {
                  anticipator.run(clip, {}, {-1, samples, 0.4, 1, "walk.bvh"});
                }),
                HasSubstr("samples: must be at "));
  Clip fast = clip;  // 30 frames in a tenth of a second
  fast.rate = 300;
  EXPECT_THAT(refusal(fast, -1), HasSubstr("at least 96 are needed")) << "of the file's own";
  Clip broken = clip;
  broken.joints = clip.joints.clone();
  broken.joints[3][4][1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(refusal(broken, -1), HasSubstr("walk.bvh: "));
  broken = clip;
  broken.rotations = clip.rotations.clone();
  broken.rotations[3][4][1] = std::numeric_limits<float>::infinity();
  EXPECT_THAT(refusal(broken, -1), HasSubstr("walk.bvh: "));
}

TEST(IntentionAnticipator, NeedsTheNetworksThatForecast) {
  const TempFolder folder;
  Networks networks = gentle();
  save_networks(folder / "all.safetensors", networks);
  const Clip clip = person("walk", 30);
  const auto loaded = IntentionAnticipator::load(folder / "all.safetensors");
  EXPECT_TRUE(loaded.config() == networks.config);
  EXPECT_TRUE(torch::equal(loaded.run(clip, {}, {-1, 1, 0.4, 1, "walk"}).futures[0].joints,
                           IntentionAnticipator(networks).run(clip, {}, {-1, 1, 0.4, 1, "walk"}).futures[0].joints));
  Networks some = networks;
  some.intention = nullptr;
  save_networks(folder / "some.safetensors", some);
  EXPECT_THAT(refusal_of([&] { IntentionAnticipator::load(folder / "some.safetensors"); }),
              HasSubstr("some.safetensors: lacks the networks"));
  some = networks;
  some.pose = nullptr;
  save_networks(folder / "some.safetensors", some);
  EXPECT_THAT(refusal_of([&] { IntentionAnticipator::load(folder / "some.safetensors"); }), HasSubstr("lacks"));
}

}  // namespace
}  // namespace inhabit::anticipate
