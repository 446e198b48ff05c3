// Protects the animator's skeleton: what networks find on the standard joints comes back on the file's own, with its
// key poses bit by bit, wrists and ankles where they were found, fingers and twist joints going along, at the file's
// rate.
#include "inhabit/motion/transfer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "animator.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/io/bvh.h"
#include "inhabit/motion/landmarks.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"
#include "refusal_of.h"

namespace inhabit {
namespace {

using torch::Tensor;

Clip animated(const AnimatorFile& file) { return parse_bvh(file.text(), "walk.bvh").clip; }

/// Key poses 0, 31, 60, 97 and 120 of a clip at 60 Hz, as a system at 30 Hz keeps them.
const std::vector<int64_t> kKeys = {0, 31, 60, 97, 120}, kAt = {0, 16, 30, 49, 60};

/// The standard motion of `whole` that meets kKeys at kAt.
Clip met_at_keys(const Clip& whole) {
  std::vector<double> times;
  for (size_t k = 0; k + 1 < kKeys.size(); ++k)
    for (int64_t t = kAt[k]; t < kAt[k + 1]; ++t)
      times.push_back(static_cast<double>(kKeys[k]) + static_cast<double>((t - kAt[k]) * (kKeys[k + 1] - kKeys[k])) /
                                                          static_cast<double>(kAt[k + 1] - kAt[k]));
  times.push_back(120);
  Clip out = at_frames(whole, times);
  out.rate = 30;
  return out;
}

/// Distances (T) of a joint of the result from where the standard one is at the same time.
Tensor missed(const Clip& result, int joint, const Clip& motion, int standard) {
  return (result.joints.select(1, joint) - motion.joints.select(1, standard)).norm(2, {1});
}

std::vector<std::pair<int, int>> ends(const Skeleton& skeleton) {
  const Landmarks marks = find_landmarks(skeleton, "test");
  return {{marks.wrist[0], 20}, {marks.wrist[1], 21}, {marks.ankle[0], 7}, {marks.ankle[1], 8}};
}

TEST(Transfer, KeysComeOutAsTheyWentInAndTheRecordingBetweenThem) {
  for (const bool world_root : {false, true})
    for (const bool stretching : {false, true}) {
      AnimatorFile file;
      file.world_root = world_root;
      file.stretching = stretching;
      const Clip clip = animated(file), standard = retarget(clip, "walk.bvh");
      const Clip result =
          on_source_skeleton(met_at_keys(standard), poses_of(clip, standard, kKeys, kKeys, kAt), clip.frames());
      EXPECT_EQ(result.skeleton.names, clip.skeleton.names);
      EXPECT_EQ(result.rate, 60);
      EXPECT_EQ(result.file.channels, clip.file.channels);
      ASSERT_EQ(result.frames(), clip.frames());
      for (const int64_t key : kKeys) {
        EXPECT_TRUE(torch::equal(result.rotations[key], clip.rotations[key])) << key;
        EXPECT_TRUE(torch::equal(result.joints[key], clip.joints[key])) << key;
        EXPECT_TRUE(torch::equal(result.trans[key], clip.trans[key])) << key;
      }
      for (const auto& [joint, name] : ends(clip.skeleton))
        EXPECT_LT(missed(result, joint, standard, name).max().item<double>(), 0.005) << joint << stretching;
      // Nothing jumps, neither at keys nor elsewhere: no joint moves faster than the recording's fastest by much.
      const auto fastest = [](const Clip& c) { return c.joints.diff(1, 0).norm(2, {2}).max().item<double>(); };
      EXPECT_LT(fastest(result), 1.3 * fastest(clip));
    }
}

TEST(Transfer, FingersFaceAndTwistJointsAreInterpolated) {
  const Clip clip = animated({}), standard = retarget(clip, "walk.bvh");
  const SourcePoses poses = poses_of(clip, standard, kKeys, kKeys, kAt);
  const Clip result = on_source_skeleton(met_at_keys(standard), poses, clip.frames());
  for (const char* name : {"LeftHandIndex1", "RightHandThumb2", "Jaw", "LeftArmTwist"}) {
    const int j = clip.skeleton.find(name);
    ASSERT_GE(j, 0);
    // Half way from key 60 to key 120 by way of 97: on the shorter arc, so between the two in every part.
    const Tensor a = clip.rotations[60][j], b = clip.rotations[97][j], mid = result.rotations[75][j];
    const double weight = 15.0 / 37;
    EXPECT_LT((mid - (a + weight * (b - a))).norm().item<double>(), 0.02) << name;
  }
}

TEST(Transfer, AnotherMotionIsFollowedByWristsAndAnkles) {
  for (const std::string name : {"plain", "bent"}) {
    const Clip clip = animated({}), standard = retarget(clip, "walk.bvh");
    Clip motion = met_at_keys(standard);
    // A motion that the file does not have, but for its keys: bends of the back and larger swings that fade at keys.
    Tensor fade = torch::ones({61});
    for (const int64_t key : kAt) fade *= 1 - torch::exp(-0.05 * (torch::arange(61) - key).square());
    Tensor rotations = motion.rotations.clone();
    rotations.slice(1, 16, 20).add_(fade.view({-1, 1, 1}) * torch::tensor({0.3F, 0.2F, -0.1F}));
    if (name == "bent") rotations.slice(1, 3, 10).select(2, 0).add_(0.15 * fade.unsqueeze(1));
    motion.rotations = rotations;
    motion.joints = joint_positions(motion.skeleton, motion.rotations, motion.trans);
    const SourcePoses poses = poses_of(clip, standard, kKeys, kKeys, kAt);
    const Clip result = on_source_skeleton(motion, poses, clip.frames());
    std::vector<double> times;
    for (int64_t f = 0; f < clip.frames(); ++f) times.push_back(0.5 * static_cast<double>(f));
    for (size_t k = 0; k + 1 < kKeys.size(); ++k)
      for (int64_t f = kKeys[k]; f <= kKeys[k + 1]; ++f)
        times[static_cast<size_t>(f)] =
            static_cast<double>(kAt[k]) +
            static_cast<double>((f - kKeys[k]) * (kAt[k + 1] - kAt[k])) / static_cast<double>(kKeys[k + 1] - kKeys[k]);
    const Clip wanted = at_frames(motion, times);
    for (const auto& [joint, standard_joint] : ends(clip.skeleton))
      EXPECT_LT(missed(result, joint, wanted, standard_joint).max().item<double>(), 0.005) << name << joint;
    const Landmarks marks = find_landmarks(clip.skeleton, "test");
    for (const auto& [joint, standard_joint] : {std::pair(marks.toe[0], 10), {marks.toe[1], 11}})
      EXPECT_LT(missed(result, joint, wanted, standard_joint).max().item<double>(), 0.005) << name << joint;
    EXPECT_LT(missed(result, marks.pelvis, wanted, 0).max().item<double>(), 0.001);
    for (const auto& [joint, standard_joint] : {std::pair(marks.head, 15), {marks.elbow[0], 18}, {marks.knee[1], 5}})
      EXPECT_LT(missed(result, joint, wanted, standard_joint).max().item<double>(), 0.02) << name << joint;
    // Bones keep their lengths.
    const Tensor posed = joint_positions(result.skeleton, result.rotations, result.trans);
    EXPECT_LT((posed - result.joints).norm(2, {2}).max().item<double>(), 1e-4);
  }
}

TEST(Transfer, WhatFollowsLeavesFromTheLastPoseWithoutAJump) {
  for (const double rate : {24.0, 30.0, 60.0, 120.0}) {
    AnimatorFile file;
    file.rate = rate;
    file.frames = static_cast<int>(2 * rate);
    const Clip clip = animated(file);
    const auto start = static_cast<int64_t>(rate);
    int64_t at = 0;
    const Clip standard = resample_through(retarget(clip, "walk.bvh"), 30, start - 1, at);
    const Clip future = slice(standard, at + 1, at + 25), last = slice(standard, at, at + 1);
    const Clip result = going_on(clip, start, last, future);
    EXPECT_EQ(result.rate, rate);
    EXPECT_EQ(result.frames(), static_cast<int64_t>(std::floor(24 * rate / 30 + 1e-6)));
    // The truth is known, but for fingers and face, which are held.
    const Clip truth = slice(clip, start, start + result.frames());
    const Tensor steps = clip.joints.diff(1, 0).norm(2, {2}).amax({0});
    const Tensor first = (result.joints[0] - clip.joints[start - 1]).norm(2, {1});
    EXPECT_TRUE(first.le(1.3 * steps + 1e-3).all().item<bool>()) << rate << first;
    for (const auto& [joint, name] : ends(clip.skeleton)) {
      const Tensor error = (result.joints.select(1, joint) - truth.joints.select(1, joint)).norm(2, {1});
      EXPECT_LT(error.max().item<double>(), 0.01) << rate << " " << joint;
    }
    const int jaw = clip.skeleton.find("Jaw");
    EXPECT_LT((result.rotations.select(1, jaw) - clip.rotations[start - 1][jaw]).abs().max().item<double>(), 1e-5);
    const Tensor labels = torch::arange(24);
    const Tensor spread = labels_going_on(labels, 30, rate);
    EXPECT_EQ(spread.size(0), result.frames());
    EXPECT_EQ(spread[-1].item<int64_t>(), 23);
  }
}

TEST(Transfer, PositionsAloneAreOnTheStandardSkeletonAtTheirRate) {
  const Clip clip = animated({}), standard = retarget(clip, "walk.bvh");
  Clip positions = standard;
  positions.rotations = positions.trans = Tensor();
  const Clip result =
      on_source_skeleton(met_at_keys(standard), poses_of(positions, standard, kKeys, kKeys, kAt), clip.frames());
  EXPECT_EQ(result.skeleton.names, standard_joint_names());
  EXPECT_EQ(result.frames(), clip.frames());
  EXPECT_EQ(result.rate, 60);
}

TEST(Transfer, PosesBetweenTwoFramesOfTheMotionAreMetToo) {
  AnimatorFile file;
  file.rate = 120;
  const Clip clip = animated(file), standard = retarget(clip, "walk.bvh");
  std::vector<int64_t> keys;
  for (int64_t f = 0; f < 121; f += 3) keys.push_back(f);
  // At 30 Hz only some of them have a frame of their own.
  std::vector<int64_t> kept, at;
  for (const int64_t key : keys)
    if (const int64_t frame = std::llround(static_cast<double>(key) / 4); at.empty() || frame > at.back())
      kept.push_back(key), at.push_back(frame);
  ASSERT_LT(kept.size(), keys.size());
  std::vector<double> times;
  for (int64_t t = 0; t <= at.back(); ++t) times.push_back(4.0 * static_cast<double>(t));
  Clip motion = at_frames(standard, times);
  motion.rate = 30;
  const Clip result = on_source_skeleton(motion, poses_of(clip, standard, keys, kept, at), clip.frames());
  for (const int64_t key : keys) EXPECT_TRUE(torch::equal(result.rotations[key], clip.rotations[key])) << key;
}

TEST(Transfer, SaysWhatDoesNotAgree) {
  const Clip clip = animated({}), standard = retarget(clip, "walk.bvh");
  SourcePoses poses = poses_of(clip, standard, kKeys, kKeys, kAt);
  poses.frames[1] = 0;
  EXPECT_THAT(refusal_of([&] { on_source_skeleton(standard, poses, 10); }), testing::HasSubstr("not in order"));
  poses.frames.pop_back();
  EXPECT_THAT(refusal_of([&] { on_source_skeleton(standard, poses, 10); }), testing::HasSubstr("differ in number"));
  EXPECT_THAT(refusal_of([&] { on_source_skeleton(clip, poses_of(clip, clip, kKeys, kKeys, kAt), 10); }),
              testing::HasSubstr("standard skeleton"));
}

}  // namespace
}  // namespace inhabit
