// Protects contacts of hands: a hand that rests on something of the scene is found, stays there and leaves smoothly;
// one that slides over it, is still in the air or has no scene is left alone.
#include <gtest/gtest.h>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/body/palm.h"
#include "inhabit/math/smooth_step.h"
#include "inhabit/refine/refine_clip.h"
#include "inhabit/refine/trajectory.h"
#include "inhabit/scene/shapes.h"

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;

constexpr int64_t kFrames = 120, kDown = 40, kUp = 70, kSwing = 12;
constexpr int kLeft = 20, kShoulder = 16;

Track palm_track(const Clip& clip, int side) {
  Track out;
  for (const BonesPose& pose : posed(bones_of(clip.skeleton), trajectory_of(clip)))
    out.push_back(place_of({Attachment{kLeft + side, 1, palm_offset(side).cast<double>()}}, pose));
  return out;
}

void place_joints(Clip& clip) { clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans); }

/// Arms straight out, the left one raised but in frames kDown to kUp.
Clip lays_a_hand_down() {
  Clip out;
  out.skeleton = builtin_body().skeleton;
  out.rate = 30;
  out.rotations = torch::zeros({kFrames, kStandardJoints, 3});
  out.trans = torch::zeros({kFrames, 3});
  for (int64_t t = 0; t < kFrames; ++t) {
    const double swing = kSwing;
    out.rotations[t][kShoulder][2] = 0.4 * (1 - smooth_step(static_cast<double>(t - kDown + kSwing) / swing) +
                                            smooth_step(static_cast<double>(t - kUp) / swing));
  }
  place_joints(out);
  out.trans.select(1, 1).sub_(out.joints.select(2, 1).min() - 0.02);
  place_joints(out);
  return out;
}

Clip jittered(const Clip& clip) {
  torch::manual_seed(5);
  Clip out = clip;
  out.rotations = clip.rotations + torch::randn_like(clip.rotations) * (0.5 * M_PI / 180);
  out.trans = clip.trans + torch::randn_like(clip.trans) * 0.005;
  place_joints(out);
  return out;
}

/// A floor and a box whose top is `under` metres under a place.
Scene box_under(const Vector3d& place, double under, double half_length = 0.08) {
  Scene out = floor_scene();
  MeshBuilder box;
  box.box({place.x(), place.y() - under - 0.1, place.z()}, {half_length, 0.1, 0.08});
  out.meshes.push_back(box.mesh("box", {1, 1, 1}));
  return out;
}

Clip slice_of_rest() { return slice(lays_a_hand_down(), kDown, kUp); }

double fastest_change(const Track& track) {  // m/s^2
  double most = 0;
  for (size_t t = 1; t + 1 < track.size(); ++t)
    most = std::max(most, (track[t + 1] - 2 * track[t] + track[t - 1]).norm() * 900);
  return most;
}

TEST(RefineHands, AHandThatRestsIsHeldAndLeavesSmoothly) {
  const Clip truth = lays_a_hand_down(), input = jittered(truth);
  const Vector3d rest = palm_track(truth, 0)[kDown + 5];
  const Result result = refine(input, box_under(rest, 0));
  ASSERT_EQ(result.hands.size(), 1U);
  const GivenContact& hand = result.hands[0];
  EXPECT_EQ(hand.joint, kLeft);
  EXPECT_NEAR(static_cast<double>(hand.first), kDown, 4);
  EXPECT_NEAR(static_cast<double>(hand.last), kUp, 4);
  EXPECT_LT((hand.place - rest).norm(), 0.01);
  EXPECT_NEAR(hand.place.y(), rest.y(), 1e-4) << "on the surface";
  const Track palm = palm_track(result.clip, 0), before = palm_track(input, 0);
  double off = 0, above = 0, was = 0;
  for (int64_t t = kDown + 3; t < kUp - 2; ++t) {
    off = std::max(off, (palm[t] - palm[kDown + 15]).norm());
    above = std::max(above, std::abs(palm[t].y() - rest.y()));
    was = std::max(was, (before[t] - before[kDown + 15]).norm());
  }
  EXPECT_LT(off, 1e-3);
  EXPECT_LT(above, 1e-3);
  EXPECT_GT(was, 0.01) << "else this test says nothing";
  Options feet;
  feet.hands = false;
  const Track free = palm_track(refine(input, box_under(rest, 0), feet).clip, 0);
  EXPECT_LT(fastest_change(palm), 1.2 * fastest_change(free)) << "it comes and goes as smoothly as it does by itself";
  // It is told in the motion, for files and pages.
  ASSERT_TRUE(result.on_source.hand_targets.defined());
  EXPECT_EQ(result.on_source.hand_targets[kDown + 15][0][3].item<float>(), 1);
  EXPECT_EQ(result.on_source.hand_targets.select(1, 1).abs().sum().item<float>(), 0) << "the other is in the air";
}

TEST(RefineHands, ACleanHandIsBroughtToTheSurfaceSmoothly) {
  const Clip truth = lays_a_hand_down();
  const Vector3d rest = palm_track(truth, 0)[kDown + 5];
  const Result result = refine(truth, box_under(rest, 0.02));
  ASSERT_EQ(result.hands.size(), 1U);
  const Track palm = palm_track(result.clip, 0);
  EXPECT_NEAR(palm[kDown + 15].y(), rest.y() - 0.02, 2e-3);
  EXPECT_LT(fastest_change(palm), 1.5 * fastest_change(palm_track(truth, 0)));
}

TEST(RefineHands, OtherHandsAreLeftAlone) {
  const Clip truth = lays_a_hand_down();
  const Vector3d rest = palm_track(truth, 0)[kDown + 5];
  EXPECT_TRUE(refine(truth, {}).hands.empty()) << "nothing to rest on";
  EXPECT_TRUE(refine(truth, box_under(rest, 0.1)).hands.empty()) << "still, in the air";
  Clip slides = slice_of_rest();
  slides.trans.select(1, 0).add_(torch::arange(slides.frames()) * (0.12 / 30));
  place_joints(slides);
  EXPECT_TRUE(refine(slides, box_under(rest, 0.005, 0.5)).hands.empty()) << "12 cm in a second";
}

TEST(RefineHands, WhoSaysWhereAHandIsIsBelieved) {
  const Clip truth = lays_a_hand_down();
  const Vector3d rest = palm_track(truth, 0)[kDown + 5];
  const Scene scene = box_under(rest, 0);
  Options kept, given, feet, generated;
  kept.keep_joints = {kLeft};
  given.given.push_back({kLeft, palm_offset(0).cast<double>(), rest, kDown, kDown + 10});
  feet.hands = false;
  generated.generated = true;
  for (const Options& options : {kept, given, feet, generated})
    EXPECT_TRUE(refine(truth, scene, options).hands.empty());
}

TEST(RefineHands, WhatAMotionSaysOfItsHandsStays) {
  Clip input = lays_a_hand_down();
  input.hand_targets = torch::zeros({kFrames, 2, 4});
  const Result result = refine(input, box_under(palm_track(input, 0)[kDown + 5], 0));
  EXPECT_EQ(result.hands.size(), 1U);
  EXPECT_TRUE(torch::equal(result.clip.hand_targets, input.hand_targets));
}

}  // namespace
}  // namespace inhabit::refine
