// Protects the facade with an untrained network: keys come out as they went in, what is not given is not looked at, the
// same request gives the same motion, windows join, and what cannot be filled is refused.
#include "inhabit/inbetween/scene_inbetweener.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "forecast/walker.h"
#include "inbetween/small_network.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/inbetween/features.h"
#include "inhabit/inbetween/interpolate.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/residual.h"
#include "inhabit/math/rotation.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/motion/locomotion.h"
#include "inhabit/scene/shapes.h"
#include "largest.h"
#include "refusal_of.h"

namespace inhabit::inbetween {
namespace {

using ::testing::HasSubstr;
using torch::Tensor;

/// Windows of 121 frames, partial keys, weights of no training.
Networks networks(int t_star = 0) {
  Networks out;
  out.config = preset("features");
  out.config.width = 32;
  out.config.multipliers = {1, 1};
  out.config.scene_encoder = {12, 16, 1, 2, 8, 16};
  out.config.t_star = t_star;
  out.network = untrained(out.config);
  const Tensor features = clip_features(walker(121, 1, 0, 1));
  out.scale.mean = features.mean(0);
  out.scale.deviation = features.std(0).clamp_min(0.01);
  return out;
}

Options request(const std::string& keys, int64_t frames) {
  Options out;
  out.keys = key_frames(keys, frames);
  out.steps = 4;
  return out;
}

TEST(SceneInbetweener, MeetsKeysAndLooksAtNothingElse) {
  const SceneInbetweener inbetweener(networks());
  const Clip clip = walker(121, 1.1, 0.8, 1, 2, -1);
  const Options r = request("every:60", 121);
  const Clip filled = inbetweener.run(clip, floor_scene(), r).motion;
  ASSERT_EQ(filled.frames(), 121);
  for (const int64_t key : r.keys) EXPECT_LT(largest_difference(filled.joints[key], clip.joints[key]), 1e-3) << key;
  EXPECT_GT(largest_difference(filled.joints[30], clip.joints[30]), 0.01) << "an untrained network knows no better";
  Clip other = clip;  // garbage between the keys
  other.joints = clip.joints.clone();
  other.rotations = clip.rotations.clone();
  other.trans = clip.trans.clone();
  for (Tensor* t : {&other.joints, &other.rotations, &other.trans}) {
    t->slice(0, 1, 60).add_(0.5);
    t->slice(0, 61, 120).mul_(-2);
  }
  EXPECT_TRUE(torch::equal(inbetweener.run(other, floor_scene(), r).motion.joints, filled.joints));
}

TEST(SceneInbetweener, TheSeedSaysEverything) {
  const SceneInbetweener inbetweener(networks());
  const Clip clip = walker(50, 1, 0, 1);
  Options r = request("ends", 50);
  const Clip a = inbetweener.run(clip, floor_scene(), r).motion, b = inbetweener.run(clip, floor_scene(), r).motion;
  EXPECT_TRUE(torch::equal(a.joints, b.joints));
  r.seed = 2;
  EXPECT_FALSE(torch::equal(a.joints, inbetweener.run(clip, floor_scene(), r).motion.joints));
}

TEST(SceneInbetweener, FillsLongClipsWindowByWindow) {
  for (const int t_star : {0, 20}) {
    const SceneInbetweener inbetweener(networks(t_star));
    const Clip clip = walker(250, 1, 0.4, 1);
    Options r = request("every:30", 250);
    int64_t done = 0, all = 0;
    r.progress = [&](int64_t d, int64_t a) {
      EXPECT_EQ(d, ++done);
      all = a;
    };
    const Clip filled = inbetweener.run(clip, floor_scene(), r).motion;
    EXPECT_EQ(done, all);
    EXPECT_GT(all, 4);
    EXPECT_EQ(filled.frames(), 250);
    EXPECT_TRUE(filled.joints.isfinite().all().item<bool>());
    EXPECT_LT(largest_difference(filled.joints[249], clip.joints[249]), 2e-3) << "the end is clean";
    if (t_star > 0) continue;
    for (const int64_t key : r.keys) EXPECT_LT(largest_difference(filled.joints[key], clip.joints[key]), 2e-3) << key;
  }
}

TEST(SceneInbetweener, PartialKeysAndScenesWithNothingNear) {
  const SceneInbetweener inbetweener(networks());
  const Clip clip = walker(61, 1, 0, 1);
  Options r = request("every:30", 61);
  r.key_groups = key_groups("pelvis,left_wrist");
  const Clip filled = inbetweener.run(clip, floor_scene(2, 90, 90), r).motion;
  EXPECT_TRUE(filled.joints.isfinite().all().item<bool>());
  EXPECT_LT(largest_difference(filled.joints[30][0], clip.joints[30][0]), 1e-3) << "the root is a feature of its own";
  EXPECT_LT(largest_difference(filled.joints[60], clip.joints[60]), 1e-3) << "ends are whole";
}

TEST(SceneInbetweener, JointsThatPartialKeysGiveAreReached) {
  const SceneInbetweener inbetweener(networks());
  const Clip clip = walker(91, 1, 0, 1);
  for (const std::string joints :
       {"head", "pelvis,left_wrist", "left_wrist,right_wrist", "left_foot", "right_ankle,left_wrist,neck"}) {
    Options r = request("every:30", 91);
    r.key_groups = key_groups(joints);
    const Clip filled = inbetweener.run(clip, floor_scene(), r).motion;
    for (const int64_t key : {30, 60})
      for (int64_t j = 0; j < kStandardJoints; ++j) {
        if (r.key_groups[kJointGroups + j].item<float>() == 0) continue;
        EXPECT_LT((filled.joints[key][j] - clip.joints[key][j]).norm().item<double>(), 0.03)
            << joints << ", frame " << key << ", " << standard_joint_names()[static_cast<size_t>(j)];
      }
    EXPECT_LT(largest_difference(joint_positions(filled.skeleton, filled.rotations, filled.trans), filled.joints), 1e-3)
        << "bones keep their lengths";
    for (const int64_t end : {0, 90}) EXPECT_LT(largest_difference(filled.joints[end], clip.joints[end]), 1e-3);
  }
}

TEST(SceneInbetweener, RefusesWhatItCannotFill) {
  const SceneInbetweener inbetweener(networks());
  const Scene floor = floor_scene();
  const Clip clip = walker(200, 1);
  const auto refused = [&](const Clip& c, const std::vector<int64_t>& keys) {
    Options r;
    r.keys = keys;
    return refusal_of([&] { inbetweener.run(c, floor, r); });
  };
  EXPECT_THAT(refused(clip, {0}), HasSubstr("fewer than two"));
  EXPECT_THAT(refused(clip, {0, 100}), HasSubstr("the last frame"));
  EXPECT_THAT(refused(clip, {0, 100, 60, 199}), HasSubstr("not in order"));
  EXPECT_THAT(refused(clip, {0, 199}), HasSubstr("199 frames apart"));
  for (Tensor Clip::*part : {&Clip::joints, &Clip::rotations, &Clip::trans}) {
    Clip broken = clip;
    broken.*part = (clip.*part).clone();
    (broken.*part)[100].fill_(NAN);
    EXPECT_THAT(refused(broken, {0, 100, 199}), HasSubstr("finite"));
  }
  Networks other = networks();
  other.config.anchors = 6;
  EXPECT_THAT(refusal_of([&] { SceneInbetweener{other}; }), HasSubstr("6 anchors"));
}

TEST(SceneInbetweener, TakesAnyRateAndPositionsAlone) {
  const SceneInbetweener inbetweener(networks());
  Clip slow = walker(100, 1);
  slow.rate = 25;
  const Result filled = inbetweener.run(slow, floor_scene(), request("every:50", 100));
  EXPECT_EQ(filled.motion.rate, 30);
  EXPECT_EQ(filled.keys, (std::vector<int64_t>{0, 60, 119}));
  EXPECT_LT(largest_difference(filled.motion.joints[60], slow.joints[50]), 2e-3);
  Clip positions = walker(61, 1);
  positions.rotations = positions.trans = Tensor();
  const Result posed = inbetweener.run(positions, {}, request("every:30", 61));
  EXPECT_TRUE(posed.floor_assumed);
  EXPECT_LT(largest_difference(posed.motion.joints[30], positions.joints[30]), 0.03);
}

// Of a file on the standard skeleton whose joints translate: the model knows rigid bones, the file's skeleton does not.
TEST(SceneInbetweener, JointsThatTranslateDoSoOnTheirOwnSkeletonAlone) {
  const SceneInbetweener inbetweener(networks());
  Clip clip = walker(121, 1.1, 0.8, 1, 2, -1);
  Tensor places = clip.skeleton.offsets.unsqueeze(0).repeat({121, 1, 1});
  places.select(1, 18).add_(0.04 * torch::sin(torch::arange(121) * 0.1).unsqueeze(1));
  set_translations(clip, places);
  const Options r = request("every:60", 121);
  const Result filled = inbetweener.run(clip, floor_scene(), r);
  EXPECT_FALSE(filled.motion.translations.defined());
  const Clip& motion = filled.motion;
  EXPECT_LT(largest_difference(motion.joints, joint_positions(motion.skeleton, motion.rotations, motion.trans)), 1e-5);
  ASSERT_TRUE(filled.on_source.translations.defined());
  for (const int64_t key : r.keys) EXPECT_TRUE(torch::equal(filled.on_source.joints[key], clip.joints[key])) << key;
  const auto moved = [](const Clip& c, int64_t frame) { return c.joints[frame + 1] - c.joints[frame]; };
  for (const int64_t frame : {59, 60, 119})
    EXPECT_LT(largest(moved(filled.on_source, frame) - moved(motion, frame)), 0.01)
        << "no jump beside a key, " << frame;
}

TEST(SceneInbetweener, ServesSeveralThreadsAtOnce) {
  const SceneInbetweener inbetweener(networks());
  const Clip clip = walker(61, 1);
  const Options r = request("every:30", 61);
  const Tensor expected = inbetweener.run(clip, floor_scene(), r).motion.joints;
  std::vector<Tensor> found(4);
  std::vector<std::thread> threads;
  for (Tensor& out : found) threads.emplace_back([&] { out = inbetweener.run(clip, floor_scene(), r).motion.joints; });
  for (std::thread& thread : threads) thread.join();
  for (const Tensor& out : found) EXPECT_TRUE(torch::allclose(out, expected, 0, 1e-5));
}

/// A wall across the path ahead, and a block to its left.
Scene room_ahead() {
  Scene scene = floor_scene();
  MeshBuilder walls;
  walls.box({0.23, 1.03, 1.21}, {0.92, 0.98, 0.04});  // no face of which lies between squares of the grid
  walls.box({1.53, 0.43, 0.52}, {0.31, 0.41, 0.4});
  scene.meshes.push_back(walls.mesh("wall", {1, 1, 1}));
  return scene;
}

TEST(SceneInbetweener, TurnsAndRaisesWithItsRoom) {
  // What is seen of the room must rotate with the person: a wrong sign in occupancy, offsets or the detour
  // would change the motion.
  const SceneInbetweener inbetweener(networks());
  const Clip clip = walker(121, 0.5, 0, 1);
  const Scene room = room_ahead();
  const Options r = request("ends", 121);
  const Clip filled = inbetweener.run(clip, room, r).motion;
  EXPECT_FALSE(torch::allclose(filled.joints, inbetweener.run(clip, floor_scene(), r).motion.joints, 0, 1e-2))
      << "the room is seen";
  for (const GroundTransform& by :
       {GroundTransform{2.2, {1.3, 0, -0.4}}, GroundTransform{-0.7, {0, 0.7, 2}}, GroundTransform{0, {0, -0.9, 0}}}) {
    Scene moved = room;
    for (Mesh& mesh : moved.meshes) {
      const Tensor shift = torch::tensor({by.shift.x(), by.shift.y(), by.shift.z()}, torch::kFloat32);
      mesh.vertices = mesh.vertices.matmul(yaw_matrix(by.yaw).t()) + shift;
    }
    const Clip there = inbetweener.run(transformed(clip, by), moved, r).motion;
    EXPECT_LT((transformed(filled, by).joints - there.joints).norm(2, {2}).mean().item<double>(), 0.01) << by.yaw;
  }
}

/// Residual motion: small sizes, weights of no training.
Networks residual_networks() {
  Networks out;
  out.config = preset("compact");
  out.config.width = 32;
  out.config.multipliers = {1, 1};
  out.network = untrained(out.config);
  torch::manual_seed(6);
  out.residual_table = torch::rand({kScaleRows, kResidualFeatures}) * 0.1;
  out.residual_table[0].zero_();
  return out;
}

Scene scene_with_block() {
  Scene scene = floor_scene();
  MeshBuilder block;
  block.box({0.3, 0.5, 2.5}, {0.5, 0.5, 0.4});
  scene.meshes.push_back(block.mesh("block", {0.5F, 0.5F, 0.5F}));
  return scene;
}

TEST(SceneInbetweener, OfResidualMotionPassesThroughItsKeys) {
  const SceneInbetweener inbetweener(residual_networks());
  const Clip clip = walker(161, 1.1, 0.8, 1, 2, -1);  // of two windows
  Options r = request("every:40", 161);
  r.clean_feet = false;
  const Clip filled = inbetweener.run(clip, floor_scene(), r).motion;
  for (const int64_t key : r.keys) {
    EXPECT_TRUE(torch::equal(filled.rotations[key], clip.rotations[key])) << key << ": bit by bit";
    EXPECT_LT(largest_difference(filled.joints[key], clip.joints[key]), 1e-5) << key;
  }
  EXPECT_GT(largest_difference(filled.joints[20], clip.joints[20]), 0.01) << "an untrained network knows no better";
  EXPECT_TRUE(torch::equal(inbetweener.run(clip, floor_scene(), r).motion.joints, filled.joints));
  r.seed = 2;
  EXPECT_GT(largest_difference(inbetweener.run(clip, floor_scene(), r).motion.joints, filled.joints), 1e-3);
}

TEST(SceneInbetweener, OfResidualMotionSeesTheSceneUnlessGuidanceIsZero) {
  Networks seeing = residual_networks(), blind = seeing;
  blind.config.inference.guidance = 0;
  const Clip clip = walker(121, 1.1, 0, 1);
  Options r = request("ends", 121);
  r.clean_feet = false;
  r.way_around = false;  // what the network sees, not what the baseline goes around
  const auto difference = [&](const Networks& networks) {
    const SceneInbetweener inbetweener(networks);
    return largest_difference(inbetweener.run(clip, floor_scene(), r).motion.joints,
                              inbetweener.run(clip, scene_with_block(), r).motion.joints);
  };
  EXPECT_GT(difference(seeing), 1e-4);
  EXPECT_EQ(difference(blind), 0);
}

TEST(SceneInbetweener, OfResidualMotionStartsFromItsBaseline) {
  const SceneInbetweener inbetweener(residual_networks());
  ASSERT_TRUE(inbetweener.has_baseline());
  const Clip clip = walker(121, 1.1, 0.8, 1);
  Options r = request("every:60", 121);
  r.stage = Stage::baseline;
  EXPECT_LT(largest_difference(inbetweener.run(clip, floor_scene(), r).motion.joints,
                               interpolate_linear(clip, r.keys).joints),
            1e-4);
}

}  // namespace
}  // namespace inhabit::inbetween
