// Protects the window of poses that streams share: what comes at even times comes out as it went in, uneven times,
// gaps and unseen joints are filled as the header says, and its memory does not grow.
#include "inhabit/motion/pose_window.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "inhabit/motion/pose_stream.h"
#include "inhabit/motion/resample.h"
#include "poses.h"
#include "refusal_of.h"

namespace inhabit {
namespace {

using testing::HasSubstr;
using torch::Tensor;

PoseWindow window(double seconds = 1, double longest_gap = 0.5) {
  return PoseWindow(standing_skeleton(), seconds, longest_gap);
}

/// Somebody who stands at (x, 0.95, z), faces `heading`, and moves as smooth functions of time.
Tensor standing(double time, double speed = 1, double heading = 0) {
  const Tensor rest = standing_skeleton().rest_joints();
  Tensor out = rest.clone();
  const auto c = static_cast<float>(std::cos(heading)), s = static_cast<float>(std::sin(heading));
  out.select(1, 0).copy_(c * rest.select(1, 0) + s * rest.select(1, 2));
  out.select(1, 2).copy_(c * rest.select(1, 2) - s * rest.select(1, 0));
  out.select(1, 1).add_(static_cast<float>(0.95 + 0.03 * std::sin(7 * time)));
  out.select(1, 2).add_(static_cast<float>(speed * time));
  out[20][0] += static_cast<float>(0.2 * std::sin(5 * time));
  return out;
}

TEST(PoseWindow, EvenTimesComeOutAsTheyWentIn) {
  PoseWindow w = window();
  for (int64_t t = 0; t < 90; ++t) w.push(1.7e9 + static_cast<double>(t) / 30, walk().joints[t]);
  const Clip clip = w.clip(30, 30);
  EXPECT_EQ(clip.frames(), 30);
  EXPECT_EQ(clip.rate, 30);
  EXPECT_TRUE(torch::equal(clip.joints, walk().joints.slice(0, 60, 90)));
  EXPECT_EQ(w.clip(30, 1).frames(), 1);
}

TEST(PoseWindow, OtherRatesAreThoseOfResampling) {
  PoseWindow w = window(2.8);
  for (int64_t t = 0; t < 90; ++t) w.push(static_cast<double>(t) / 30, walk().joints[t]);
  int64_t at = 0;
  const Clip expected = resample_through(walk(), 25, 89, at);
  const Clip got = w.clip(25, 40);
  EXPECT_LT(largest_difference(got.joints, expected.joints.slice(0, at - 39, at + 1)), 1e-5F);
}

TEST(PoseWindow, UnevenTimesAreFollowed) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> step(0.01, 0.045);
  PoseWindow w = window();
  double time = 100;
  for (int i = 0; i < 80; ++i, time += step(random)) w.push(time, standing(time));
  const Clip clip = w.clip(30, 30);
  ASSERT_EQ(clip.frames(), 30);
  for (int64_t t = 0; t < 30; ++t)
    EXPECT_LT(largest_difference(clip.joints[t], standing(w.last() - static_cast<double>(29 - t) / 30)), 0.002F) << t;
}

TEST(PoseWindow, MillisecondsAreEnough) {
  PoseWindow w = window(29.0 / 30);
  for (int64_t t = 0; t < 30; ++t)
    w.push(std::round(1000 * static_cast<double>(t) / 30) / 1000, standing(static_cast<double>(t) / 30));
  EXPECT_EQ(w.clip(30, 30).frames(), 30);
}

TEST(PoseWindow, AThousandPosesASecondAreThinned) {
  PoseWindow w = window();
  for (int i = 0; i < 5000; ++i) w.push(i / 1000.0, standing(i / 1000.0));
  EXPECT_DOUBLE_EQ(w.last(), 4.999);
  EXPECT_GE(w.seconds(), 1);
  const Clip clip = w.clip(30, 30);
  ASSERT_EQ(clip.frames(), 30);
  for (int64_t t = 0; t < 30; ++t)
    EXPECT_LT(largest_difference(clip.joints[t], standing(4.999 - static_cast<double>(29 - t) / 30)), 0.001F);
}

TEST(PoseWindow, AShortGapIsCrossedAndALongOneBeginsAnew) {
  PoseWindow w = window();
  for (int i = 0; i < 60; ++i)
    if (i < 40 || i >= 50) w.push(i / 30.0, standing(i / 30.0));  // 0.37 s without a pose
  const Clip crossed = w.clip(30, 30);
  ASSERT_EQ(crossed.frames(), 30);
  EXPECT_LT(largest_difference(crossed.joints.select(1, 0), torch::stack([] {
                                 std::vector<Tensor> all;
                                 for (int i = 30; i < 60; ++i) all.push_back(standing(i / 30.0)[0]);
                                 return all;
                               }())),
            0.06F);
  w.push(59 / 30.0 + 0.6, standing(3));
  EXPECT_EQ(w.seconds(), 0);
  EXPECT_EQ(w.clip(30, 30).frames(), 1);
}

TEST(PoseWindow, UnseenJointsStayWhereTheyWereFromTheirParentsAndTurnWithThePerson) {
  const float nan = NAN;
  PoseWindow w = window();
  for (int i = 0; i < 60; ++i) {
    const double yaw = i < 45 ? 0 : (i - 45) * 0.1;  // 80 degrees, while the left arm is unseen
    Tensor pose = standing(0, 0, yaw);
    if (i >= 45)
      for (const int j : {18, 20}) pose[j].fill_(nan);
    if (i % 2 == 0) pose[8][1].fill_(nan);  // a coordinate is enough; between two frames that saw it
    w.push(i / 30.0, pose);
  }
  const Clip clip = w.clip(30, 30);
  for (int64_t t = 0; t < 30; ++t) {
    const double yaw = t < 15 ? 0 : (t - 15) * 0.1;
    const bool last = t == 29;  // frame 59 saw the ankle
    EXPECT_LT(largest_difference(clip.joints[t], standing(0, 0, yaw)), last ? 1e-4F : 0.02F) << t;
  }
}

TEST(PoseWindow, JointsThatWereNeverSeenStandAsTheSkeletonDoes) {
  PoseWindow w = window();
  for (int i = 0; i < 40; ++i) {
    Tensor pose = standing(0, 0, 0.7);
    for (const int j : {7, 8, 10, 11}) pose[j].fill_(NAN);  // behind a table
    w.push(i / 30.0, pose);
  }
  EXPECT_LT(largest_difference(w.clip(30, 30).joints[29], standing(0, 0, 0.7)), 1e-4F);

  Skeleton unknown = standing_skeleton();
  unknown.offsets = torch::zeros({22, 3});
  PoseWindow bare(unknown, 1, 0.5);
  Tensor pose = standing(0);
  pose[15].fill_(NAN);
  bare.push(0, pose);
  EXPECT_EQ(refusal_of([&] { bare.clip(30, 30); }), "joints: head was never seen");
}

TEST(PoseWindow, ARootThatIsUnseenIsBetweenTheHips) {
  PoseWindow w = window();
  Tensor pose = standing(0, 0, 1.1);
  w.push(0, pose);
  pose = standing(0, 0, 2.0);
  const Tensor root = pose[0].clone();
  pose[0].fill_(NAN);
  w.push(0.03, pose);
  EXPECT_LT(largest_difference(w.clip(30, 1).joints[0][0], root), 1e-5F);
  pose[1].fill_(NAN);
  EXPECT_THAT(refusal_of([&] { w.push(0.06, pose); }), HasSubstr("neither pelvis nor both hips"));
  EXPECT_EQ(w.last(), 0.03);
}

TEST(PoseWindow, RefusesWhatIsNoPoseAndGoesOn) {
  PoseWindow w = window();
  w.push(10, standing(0));
  EXPECT_THAT(refusal_of([&] { w.push(10, standing(0)); }), HasSubstr("not after"));
  EXPECT_THAT(refusal_of([&] { w.push(9.5, standing(0)); }), HasSubstr("not after"));
  EXPECT_THAT(refusal_of([&] { w.push(NAN, standing(0)); }), HasSubstr("time"));
  EXPECT_THAT(refusal_of([&] { w.push(1e300, standing(0)); }), HasSubstr("time"));
  EXPECT_THAT(refusal_of([&] { w.push(10.1, standing(0).slice(0, 1)); }), HasSubstr("(22, 3)"));
  Tensor far = standing(0);
  far[3][1] = 2e4F;
  EXPECT_THAT(refusal_of([&] { w.push(10.1, far); }), HasSubstr("spine1 is over 10 km"));
  w.push(10.1, standing(0));
  EXPECT_NEAR(w.seconds(), 0.1, 1e-12);
  w.push(1e10, standing(0));  // a wrong time stamp, and back to the right ones
  w.push(10.2, standing(0));
  EXPECT_EQ(w.seconds(), 0);
}

TEST(UsualSkeleton, NamesAloneAreEnough) {
  const std::vector<std::string> kinect = {
      "PELVIS",      "SPINE_NAVAL", "SPINE_CHEST",  "NECK",       "CLAVICLE_LEFT",  "SHOULDER_LEFT",  "ELBOW_LEFT",
      "WRIST_LEFT",  "HAND_LEFT",   "HANDTIP_LEFT", "THUMB_LEFT", "CLAVICLE_RIGHT", "SHOULDER_RIGHT", "ELBOW_RIGHT",
      "WRIST_RIGHT", "HIP_LEFT",    "KNEE_LEFT",    "ANKLE_LEFT", "FOOT_LEFT",      "HIP_RIGHT",      "KNEE_RIGHT",
      "ANKLE_RIGHT", "FOOT_RIGHT",  "HEAD",         "NOSE",       "EYE_LEFT",       "EAR_RIGHT"};
  const UsualSkeleton usual = usual_skeleton(kinect, {}, "names");
  const auto parent = [&](const std::string& name) {
    const int p = usual.skeleton.parents[static_cast<size_t>(usual.skeleton.find(name))];
    return p < 0 ? "" : usual.skeleton.names[static_cast<size_t>(p)];
  };
  EXPECT_EQ(parent("PELVIS"), "");
  EXPECT_EQ(parent("SPINE_CHEST"), "SPINE_NAVAL");
  EXPECT_EQ(parent("NECK"), "SPINE_CHEST");
  EXPECT_EQ(parent("SHOULDER_LEFT"), "CLAVICLE_LEFT");
  EXPECT_EQ(parent("CLAVICLE_RIGHT"), "SPINE_CHEST");
  EXPECT_EQ(parent("HANDTIP_LEFT"), "WRIST_LEFT");
  EXPECT_EQ(parent("FOOT_RIGHT"), "ANKLE_RIGHT");
  EXPECT_EQ(parent("EYE_LEFT"), "HEAD");
  for (size_t k = 0; k < usual.order.size(); ++k)
    EXPECT_EQ(usual.skeleton.names[k], kinect[static_cast<size_t>(usual.order[k])]);

  // The standard names in another order are the standard tree.
  std::vector<std::string> reversed(standard_joint_names().rbegin(), standard_joint_names().rend());
  const UsualSkeleton standard = usual_skeleton(reversed, {}, "names");
  for (int j = 0; j < 22; ++j) {
    const int k = standard.skeleton.find(standard_joint_names()[static_cast<size_t>(j)]);
    const int p = standard.skeleton.parents[static_cast<size_t>(k)],
              expected = standard_parents()[static_cast<size_t>(j)];
    if (expected >= 0)
      EXPECT_EQ(standard.skeleton.names[static_cast<size_t>(p)], standard_joint_names()[static_cast<size_t>(expected)]);
    else
      EXPECT_EQ(p, -1);
  }
}

TEST(UsualSkeleton, RefusesWhatIsNoPerson) {
  EXPECT_THAT(refusal_of([] { usual_skeleton({"a", "a"}, {}, "names"); }), HasSubstr("twice"));
  EXPECT_THAT(refusal_of([] { usual_skeleton({"a", "b"}, {}, "names"); }), HasSubstr("pelvis"));
  EXPECT_THAT(refusal_of([] { usual_skeleton({"root", "b"}, {}, "names"); }), HasSubstr("names: no joint"));
  EXPECT_THAT(refusal_of([] { usual_skeleton({"root", "b", "c"}, {-1, 2, 1}, "names"); }), HasSubstr("circle"));
  EXPECT_THAT(refusal_of([] { usual_skeleton({"root", "b"}, {-1, 7}, "names"); }), HasSubstr("does not exist"));
  EXPECT_THAT(refusal_of([] { usual_skeleton({"root", "b"}, {-1, -1}, "names"); }), HasSubstr("not one joint but 2"));
  EXPECT_THAT(refusal_of([] { usual_skeleton({"root", "b"}, {-1}, "names"); }), HasSubstr("as many parents"));
  EXPECT_THAT(refusal_of([] { usual_skeleton({}, {}, "names"); }), HasSubstr("0 joints"));
}

}  // namespace
}  // namespace inhabit
