// Protects the facade with an untrained network: keys come out as they went in, what is not given is not looked at, the
// same request gives the same motion, windows join, and what cannot be filled is refused.
#include "inhabit/inbetween/scene_inbetweener.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "at_once.h"
#include "forecast/walker.h"
#include "inbetween/small_network.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/inbetween/conditioning.h"
#include "inhabit/inbetween/evaluate.h"
#include "inhabit/inbetween/features.h"
#include "inhabit/inbetween/interpolate.h"
#include "inhabit/inbetween/keyed_clip.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/residual.h"
#include "inhabit/math/rotation.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/motion/locomotion.h"
#include "inhabit/motion/pose_track.h"
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

TEST(SceneInbetweener, ANetworkThatSeesNoKeysMeetsThemByInpainting) {
  Networks unaware = networks();
  for (bool* seen : {&unaware.config.keys_seen, &unaware.config.local_scene, &unaware.config.from_interpolation,
                     &unaware.config.partial_keys})
    *seen = false;
  validate(unaware.config, "test");
  unaware.network = untrained(unaware.config);
  // What the network is told does not depend on where keys are, nor on how near the scene is there.
  Conditioning on;
  on.groups = torch::ones({1, 121, kMaskChannels});
  const int64_t side = unaware.config.scene_encoder.side;
  on.occupancy = torch::zeros({1, side / 2, side, side});
  on.offsets = torch::ones({1, unaware.config.anchors, 3, 121});
  on.shape = torch::ones({1, kShapeFeatures});
  Networks& n = unaware;
  const auto told = [&] {
    const torch::NoGradGuard no_gradients;
    const DenoiserInput in = denoiser_input(n, on);
    return std::vector<Tensor>{in.mask.flatten(), in.local.flatten(), in.scene.flatten(), in.shape.flatten()};
  };
  const Tensor all = torch::cat(told());
  on.groups.slice(1, 1, 120).zero_();
  EXPECT_TRUE(torch::cat(told()).equal(all));
  n.config.keys_seen = true;
  EXPECT_FALSE(torch::cat(told()).equal(all));
  n.config.keys_seen = false;

  const SceneInbetweener inbetweener(unaware);
  const Clip clip = walker(121, 1.1, 0.8, 1, 2, -1);
  Options r = request("every:60", 121);
  r.stage = Stage::network;
  for (const Sampler sampler : {Sampler::ddpm, Sampler::ddim, Sampler::dpm_solver}) {
    r.sampler = sampler;
    const Clip filled = inbetweener.run(clip, floor_scene(), r).motion;
    for (const int64_t key : r.keys) EXPECT_LT(largest_difference(filled.joints[key], clip.joints[key]), 1e-3) << key;
    EXPECT_GT(largest_difference(filled.joints[30], clip.joints[30]), 0.01);
  }
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
  EXPECT_THAT(refused(clip, {0, 199}), HasSubstr("keys: 0 and 199 are 199 frames apart"));
  Options named;
  named.keys_name = "--keyframes";
  EXPECT_THAT(refusal_of([&] { inbetweener.run(clip, floor, named); }), HasSubstr("--keyframes: 0 and 199"));
  for (Tensor Clip::*part : {&Clip::joints, &Clip::rotations, &Clip::trans}) {
    Clip broken = clip;
    broken.*part = (clip.*part).clone();
    (broken.*part)[100].fill_(NAN);
    EXPECT_THAT(refused(broken, {0, 100, 199}), HasSubstr("finite"));
  }
}

TEST(SceneInbetweener, LooksFromAsManyAnchorsAndCellsAsItsConfigurationSays) {
  const Clip clip = walker(121, 1.1, 0.8, 1, 2, -1);
  MeshBuilder pillar;  // 3.5 m away: beyond the nearest 48 cells of 0.1 m, among the nearest 96
  const Tensor root = clip.joints[0][0];
  pillar.box({root[0].item<double>(), 1, root[2].item<double>() + 3.5}, {0.4, 1, 0.1});
  Scene with_pillar = floor_scene();
  with_pillar.meshes.push_back(pillar.mesh("pillar", {1, 1, 1}));
  Options raw = request("every:60", 121);
  raw.stage = Stage::network;
  raw.detours = Detours::straight;
  for (const int side : {48, 96}) {
    Networks n = networks();
    n.config.anchors = 256;
    n.config.scene_encoder.side = side;
    validate(n.config, "test");
    n.network = untrained(n.config);
    const SceneInbetweener inbetweener(n);
    const auto filled = [&](const Scene& scene) { return inbetweener.run(clip, scene, raw).motion.joints; };
    const double seen = largest_difference(filled(with_pillar), filled(floor_scene()));
    if (side == 48)
      EXPECT_EQ(seen, 0);
    else
      EXPECT_GT(seen, 1e-5);
  }
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
  for (const Tensor& out : at_once(4, [&] { return inbetweener.run(clip, floor_scene(), r).motion.joints; }))
    EXPECT_TRUE(torch::allclose(out, expected, 0, 1e-5));
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
  r.refine = false;
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

TEST(SceneInbetweener, SamplesHaveTheNextSeedsAndDifferInTheirCourse) {
  const SceneInbetweener inbetweener(residual_networks());
  const Clip clip = walker(61, 1, 0, 1);
  Options r = request("ends", 61), alone = r;
  r.refine = alone.refine = false;
  r.seed = 3;
  int64_t told = 0, all_told = 0;
  r.progress = [&](int64_t done, int64_t all) {
    EXPECT_GT(done, told);
    told = done;
    all_told = all;
  };
  const std::vector<Result> varied = inbetweener.run_samples(clip, floor_scene(), r, 2);
  EXPECT_EQ(told, all_told);
  EXPECT_EQ(all_told, 2 * r.steps) << "evaluations of both";
  r.progress = {};
  const auto run = [&](uint64_t seed, std::optional<double> temperature) {
    alone.seed = seed;
    alone.temperature = temperature;
    return inbetweener.run(clip, floor_scene(), alone).motion.joints;
  };
  ASSERT_EQ(varied.size(), 2U);
  for (const uint64_t i : {0, 1}) EXPECT_TRUE(torch::equal(varied[i].motion.joints, run(3 + i, 1))) << i;
  EXPECT_TRUE(torch::equal(run(3, {}), run(3, 0))) << "of one the likeliest course";
  EXPECT_FALSE(torch::equal(run(3, {}), run(3, 1)));
  EXPECT_TRUE(torch::equal(inbetweener.run_samples(clip, floor_scene(), r, 1)[0].motion.joints, run(3, 0)));
  r.temperature = 0;
  EXPECT_TRUE(torch::equal(inbetweener.run_samples(clip, floor_scene(), r, 2)[1].motion.joints, run(4, 0)));
  for (const int64_t samples : {-1, 0, 1001})
    EXPECT_EQ(refusal_of([&] { inbetweener.run_samples(clip, floor_scene(), r, samples); }),
              "samples: is not from 1 to 1000");
  for (const double temperature : {-0.1, 2.1, std::nan("")})
    EXPECT_EQ(refusal_of([&] { run(1, temperature); }), "temperature: is not from 0 to 2");
}

TEST(SceneInbetweener, OfResidualMotionLeavesNoisyKeysOpenButTheEnds) {
  const SceneInbetweener inbetweener(residual_networks());
  const Clip clip = walker(161, 1.1, 0.8, 1, 2, -1);  // of two windows
  Options r = request("every:20", 161);
  r.refine = false;
  r.noise = 1;
  const Clip filled = inbetweener.run(clip, floor_scene(), r).motion;
  for (const int64_t key : r.keys)
    if (key == 0 || key == 160)
      EXPECT_TRUE(torch::equal(filled.rotations[key], clip.rotations[key])) << key << ": bit by bit";
    else
      EXPECT_GT(largest_difference(filled.joints[key], clip.joints[key]), 1e-3) << key << ": changed";
  // The second window goes on from the first.
  const torch::Tensor step = (filled.trans.slice(0, 1) - filled.trans.slice(0, 0, 160)).norm(2, {1});
  EXPECT_LT(step.slice(0, 100, 120).max().item<double>(), 0.5);
  r.noise = -1;
  EXPECT_THAT(refusal_of([&] { inbetweener.run(clip, floor_scene(), r); }), HasSubstr("noise level"));
  r.noise = 1;
  Networks untold = residual_networks();
  untold.config.training.noisy = 0;
  EXPECT_THAT(refusal_of([&] { SceneInbetweener(untold).run(clip, floor_scene(), r); }),
              HasSubstr("was not trained on noisy key frames"));
  EXPECT_THAT(refusal_of([&] { SceneInbetweener(networks(20)).run(clip, floor_scene(), r); }),
              HasSubstr("without being told"));
}

TEST(SceneInbetweener, ForNoisyKeysTellsTheirNoiseFromAllFrames) {
  Networks networks = residual_networks();
  const Clip clip = walker(121, 1.1, 0.8, 1, 2, -1);
  Options r = request("every:15", 121);
  r.refine = false;
  EXPECT_EQ(SceneInbetweener(networks).run(clip, floor_scene(), r).noise, 0) << "keys are exact";
  networks.config.inference.noisy_keys = true;
  const SceneInbetweener inbetweener(networks);
  EXPECT_EQ(inbetweener.run(clip, floor_scene(), r).noise, 0.5) << "the least of keys that are said to be noisy";
  EXPECT_NEAR(inbetweener.run(noisy_keys(clip, 2, 3), floor_scene(), r).noise, 2, 0.3);
  Clip elsewhere = clip;
  elsewhere.joints = clip.joints.clone();
  elsewhere.joints[20].fill_(std::nan(""));  // no key
  EXPECT_EQ(inbetweener.run(elsewhere, floor_scene(), r).noise, 0.5);
  std::vector<int64_t> stays;  // each key until the next
  for (int64_t frame = 0; frame < 121; ++frame) stays.push_back(frame / 15 * 15);
  EXPECT_EQ(inbetweener.run(frames_at(clip, stays), floor_scene(), r).noise, 1) << "nothing between them tells";
  r.keys = {};
  EXPECT_NEAR(inbetweener.run(noisy_keys(clip, 2, 3), floor_scene(), r).noise, 2, 0.3) << "keys are its ends";
  r.noise = 0;
  EXPECT_EQ(inbetweener.run(clip, floor_scene(), r).noise, 0) << "as asked for";
}

TEST(SceneInbetweener, WithoutPathNetSearchesForDetours) {
  Networks networks = residual_networks();
  const Clip clip = walker(121, 1.1, 0, 1);
  Options r = request("ends", 121);
  r.refine = false;
  r.stage = Stage::baseline;
  const auto run = [&](Detours detours) {
    r.detours = detours;
    return SceneInbetweener(networks).run(clip, scene_with_block(), r).motion.joints;
  };
  EXPECT_FALSE(SceneInbetweener(networks).has_path_net());
  EXPECT_EQ(largest_difference(run(Detours::learned), run(Detours::searched)), 0);
  EXPECT_GT(largest_difference(run(Detours::searched), run(Detours::straight)), 0.2);
  torch::manual_seed(7);
  networks.path = PathNet();  // which knows nothing yet: what its paths run into is left to A*
  EXPECT_TRUE(SceneInbetweener(networks).has_path_net());
  EXPECT_GT(largest_difference(run(Detours::learned), run(Detours::straight)), 0.2);
  EXPECT_THAT(refusal_of([] { detours_named("left"); }), HasSubstr("none of learned, searched and straight"));
}

TEST(SceneInbetweener, OfResidualMotionSeesTheSceneUnlessGuidanceIsZero) {
  Networks seeing = residual_networks(), blind = seeing;
  blind.config.inference.guidance = 0;
  const Clip clip = walker(121, 1.1, 0, 1);
  Options r = request("ends", 121);
  r.refine = false;
  r.detours = Detours::straight;  // what the network sees, not what the baseline goes around
  const auto difference = [&](const Networks& networks) {
    const SceneInbetweener inbetweener(networks);
    return largest_difference(inbetweener.run(clip, floor_scene(), r).motion.joints,
                              inbetweener.run(clip, scene_with_block(), r).motion.joints);
  };
  EXPECT_GT(difference(seeing), 1e-4);
  EXPECT_EQ(difference(blind), 0);
}

TEST(SceneInbetweener, AHandIsWhereAContactSaysWhileItSaysSo) {
  const SceneInbetweener inbetweener(residual_networks());
  const Clip clip = walker(121, 0.3, 0, 1);
  Options r = request("ends", 121);
  const Tensor near = clip.joints[60][20];
  JointContact contact;
  contact.joint = 20;
  contact.offset = {0.085, -0.025, 0};
  contact.from = 1.5;
  contact.to = 2.2;
  contact.place = {near[0].item<double>(), near[1].item<double>() + 0.2, near[2].item<double>() + 0.2};
  r.controls.contacts = {contact};
  const Clip filled = inbetweener.run(clip, floor_scene(), r).motion;
  const auto palm_missed = [&](int64_t frame) {
    const PoseTrack track = pose_track(filled);
    const auto global = global_rotations(track, filled.skeleton.parents);
    const Tensor wrist = filled.joints[frame][20].to(torch::kFloat64).contiguous();
    return (Eigen::Map<const Eigen::Vector3d>(wrist.data_ptr<double>()) +
            global[static_cast<size_t>(frame * kStandardJoints + 20)] * contact.offset - contact.place)
        .norm();
  };
  for (int64_t frame = 45; frame <= 66; ++frame) EXPECT_LT(palm_missed(frame), 0.01) << frame;
  EXPECT_GT(palm_missed(20), 0.05);
  EXPECT_GT(palm_missed(100), 0.05);
  for (const int64_t key : r.keys) EXPECT_TRUE(torch::equal(filled.rotations[key], clip.rotations[key])) << key;
  EXPECT_LT((filled.joints.diff(1, 0)).norm(2, {2}).max().item<double>() * 30, 6) << "m/s: nothing jumps";
}

TEST(SceneInbetweener, AContactWhereNobodyCanBeInTimeIsNotTried) {
  const SceneInbetweener inbetweener(residual_networks());
  const Clip clip = walker(121, 0.3, 0, 1);
  Options r = request("ends", 121);
  const Clip without = inbetweener.run(clip, floor_scene(), r).motion;
  JointContact contact;
  contact.joint = 20;
  contact.from = contact.to = 1.5;
  contact.place = {30, 90, 20};  // centimetres
  r.controls.contacts = {contact};
  const Result far = inbetweener.run(clip, floor_scene(), r);
  EXPECT_TRUE(torch::equal(far.motion.joints, without.joints));
  EXPECT_THAT(far.contact_gaps, testing::ElementsAre(testing::Gt(80)));
}

TEST(SceneInbetweener, TheRootGoesAlongItsPath) {
  const SceneInbetweener inbetweener(residual_networks());
  const Clip clip = walker(121, 0.8, 0, 1);
  const auto root = [&](const Clip& c, int64_t frame, int64_t axis) { return c.joints[frame][0][axis].item<double>(); };
  Options r = request("every:60", 121);
  const Eigen::Vector2d beside(root(clip, 30, 0) + 0.6, root(clip, 30, 2));
  r.controls.root_path = {{1, beside}};
  const Clip filled = inbetweener.run(clip, floor_scene(), r).motion;
  EXPECT_LT((Eigen::Vector2d(root(filled, 30, 0), root(filled, 30, 2)) - beside).norm(), 0.05);
  EXPECT_LT(std::abs(root(filled, 90, 0) - root(clip, 90, 0)), 0.3) << "only between the keys around it";
  for (const int64_t key : r.keys) EXPECT_TRUE(torch::equal(filled.rotations[key], clip.rotations[key])) << key;
}

TEST(SceneInbetweener, AKeyCountsByItsWeight) {
  const SceneInbetweener inbetweener(residual_networks());
  Clip clip = walker(91, 0.8, 0, 1);
  clip.rotations = clip.rotations.clone();
  clip.rotations[40][16][2] += 1;  // an arm raised
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  Options r = request("0,40,90", 91), without = request("ends", 91);
  r.refine = without.refine = false;
  const Tensor free = inbetweener.run(clip, floor_scene(), without).motion.joints[40], key = clip.joints[40];
  const auto at = [&](double weight) {
    r.controls.key_weights = {1, weight, 1};
    return inbetweener.run(clip, floor_scene(), r).motion.joints[40];
  };
  EXPECT_LT(largest_difference(at(1), key), 1e-5);
  EXPECT_LT(largest_difference(at(0), free), 1e-4);
  const Tensor half = at(0.5);
  EXPECT_LT(largest_difference(half[0], (free[0] + key[0]) / 2), 1e-4) << "the root goes half of the distance";
  EXPECT_GT(largest_difference(half, key), 0.01);
  EXPECT_LT(largest_difference(half, key), largest_difference(free, key));
}

TEST(SceneInbetweener, ALoopEndsInItsFirstPose) {
  const SceneInbetweener inbetweener(residual_networks());
  const Clip clip = walker(91, 0.8, 0.7, 1, 2, -1);
  Options r = request("every:40", 91);
  r.controls.loop = true;
  const Result looped = inbetweener.run(clip, floor_scene(), r);
  ASSERT_EQ(looped.motion.frames(), 91);
  const auto canonical = [](const Clip& c, int64_t frame) {
    return transformed(c, canonical_transform(c, frame)).joints[frame];
  };
  EXPECT_LT(largest_difference(canonical(looped.motion, 0), canonical(looped.motion, 90)), 1e-4) << "the same pose";
  EXPECT_LT(largest_difference(looped.motion.joints[90][0].slice(0, 0, 1), clip.joints[90][0].slice(0, 0, 1)), 1e-4)
      << "where the last one stood";
  EXPECT_TRUE(torch::equal(looped.on_source.rotations[0].slice(0, 1), looped.on_source.rotations[90].slice(0, 1)));
  EXPECT_LT(largest_difference(looped.motion.joints[40], clip.joints[40]), 1e-4) << "keys between stand";
}

TEST(SceneInbetweener, WhatFollowsOnALoopsEndIsWhatFollowsOnItsStart) {
  // Two rounds of a wave that goes on over the seam, the second higher and along another line.
  Clip both = walker(181, 0, 0, 1);
  both.rotations = torch::zeros_like(both.rotations);
  both.trans = torch::tensor({0.F, 0.95F, 0.F}).expand({181, 3}).clone();
  const auto angle = [](int64_t t) {
    const double phase = 2 * M_PI * static_cast<double>(t) / 90;
    return 0.3 * std::sin(phase) + (t > 90 ? 0.1 * (1 - std::cos(phase)) : 0);
  };
  for (int64_t t = 0; t < 181; ++t) {
    both.rotations[t][16][2] = angle(t);
    both.trans[t][2] = 0.01 * static_cast<double>(t);
  }
  both.joints = joint_positions(both.skeleton, both.rotations, both.trans);
  const Clip out = folded(both);
  ASSERT_EQ(out.frames(), 91);
  const auto raised = [&](int64_t t) { return out.rotations[t][16][2].item<double>(); };
  EXPECT_NEAR(raised(90) - raised(89), angle(90) - angle(89), 1e-5);
  EXPECT_NEAR(raised(1) - raised(0), angle(91) - angle(90), 2e-4);
  EXPECT_NEAR(raised(60), angle(60), 1e-5) << "later it is the first round";
  EXPECT_LT(largest_difference(out.trans, both.trans.slice(0, 0, 91)), 1e-4);
}

TEST(SceneInbetweener, RefusesControlsThatDoNotFit) {
  const SceneInbetweener residual(residual_networks()), features(networks());
  const Clip clip = walker(61, 1);
  const auto refused = [&](const SceneInbetweener& by, const Controls& controls) {
    Options r = request("every:30", 61);
    r.controls = controls;
    return refusal_of([&] { by.run(clip, floor_scene(), r); });
  };
  Controls c;
  c.key_weights = {1, 1};
  EXPECT_THAT(refused(residual, c), HasSubstr("2 are given for 3 keys"));
  c.key_weights = {1, NAN, 1};
  EXPECT_THAT(refused(residual, c), HasSubstr("not in [0, 1]"));
  c.key_weights = {0.5, 1, 1};
  EXPECT_THAT(refused(residual, c), HasSubstr("must have 1"));
  c = {};
  c.contacts.push_back({20, Eigen::Vector3d::Zero(), 1, 2.5, Eigen::Vector3d::Zero()});
  EXPECT_THAT(refused(residual, c), HasSubstr("not within the clip's 0 to 2 s"));
  c.contacts[0].to = 1.5;
  EXPECT_THAT(refused(features, c), HasSubstr("neither contacts nor a root path"));
  c.contacts[0].place.x() = INFINITY;
  EXPECT_THAT(refused(residual, c), HasSubstr("not finite"));
  c = {};
  c.root_path = {{0.5, {0, 0}}, {0.4, {0, 0}}};
  EXPECT_THAT(refused(residual, c), HasSubstr("in order"));
  c.root_path = {{1.01, {0, 0}}};
  EXPECT_THAT(refused(residual, c), HasSubstr("a key says"));
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
