// Protects how a network's motion meets its conditioning: hard keys to the bit with the frames around smoothly along,
// joints of partial keys without more change than needed, noisy keys by their noise; bones keep their lengths.
#include "inhabit/refine/refine_generated.h"

#include <gtest/gtest.h>

#include <limits>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/io/files.h"
#include "largest.h"

namespace inhabit::refine {
namespace {

using torch::Tensor;

constexpr int64_t kKey = 30;

/// Two seconds of standing still, arms down.
Clip standing() {
  Clip clip;
  clip.skeleton = builtin_body().skeleton;
  clip.rotations = torch::zeros({61, kStandardJoints, 3});
  clip.rotations.select(1, 16).select(1, 2).fill_(-1.2);
  clip.rotations.select(1, 17).select(1, 2).fill_(1.2);
  clip.trans = torch::tensor({0.F, 0.95F, 0.F}).expand({61, 3}).contiguous();
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

void pose(Clip& clip) { clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans); }

KeyPoses keys_of(const Clip& clip, const std::vector<int64_t>& frames, const std::vector<char>& exact,
                 const std::vector<int>& joints = {}) {
  KeyPoses out;
  for (size_t k = 0; k < frames.size(); ++k) {
    if (k < exact.size() && exact[k] == 0 && !joints.empty()) {
      const auto targets = joint_targets(clip, frames[k], frames[k], {joints.begin(), joints.end()});
      out.targets.insert(out.targets.end(), targets.begin(), targets.end());
      continue;
    }
    out.frames.push_back(frames[k]);
    if (k < exact.size()) out.exact.push_back(exact[k]);
  }
  out.poses = frames_at(clip, out.frames);
  return out;
}

void expect_posed(const Clip& clip) {
  EXPECT_LT(largest(joint_positions(clip.skeleton, clip.rotations, clip.trans) - clip.joints), 1e-4);
  EXPECT_LT(largest(clip.joints.diff(1, 0)) * 30, 4) << "m/s: no joint jumps";
}

/// The key pose: the same person with arms raised to the front by `arms` radians, somewhere else by `by` and bent
/// forwards by `bent` radians at spine1.
Clip reaching(const Clip& clip, double arms, const std::vector<float>& by, double bent = 0) {
  Clip out = clip;
  out.rotations = clip.rotations.clone();
  out.trans = clip.trans.clone();
  out.rotations[kKey][16][1] = -arms;
  out.rotations[kKey][16][2] = -1.2 + 0.8 * arms;
  out.rotations[kKey][3][0] = bent;
  out.trans[kKey] += torch::tensor(by);
  pose(out);
  return out;
}

double missed(const Clip& out, const Clip& keyed, int joint) {
  return (out.joints[kKey][joint] - keyed.joints[kKey][joint]).norm().item<double>();
}

TEST(RefineGenerated, HardKeysAreMetToTheBitAndTheFramesAroundComeAlong) {
  const Clip clip = standing();
  Clip keyed = reaching(clip, 0.5, {0.1F, 0.F, 0.F});
  const Clip out = refine_generated(clip, keys_of(keyed, {0, kKey, 60}, {1, 1, 1}));
  for (const int64_t t : {int64_t{0}, kKey, int64_t{60}}) {
    EXPECT_TRUE(torch::equal(out.rotations[t], keyed.rotations[t])) << t;
    EXPECT_TRUE(torch::equal(out.trans[t], keyed.trans[t])) << t;
    EXPECT_TRUE(torch::equal(out.joints[t], keyed.joints[t])) << t;
  }
  expect_posed(out);
  const Tensor x = out.trans.select(1, 0);
  EXPECT_GT(x[kKey - 5].item<double>(), 0.07);
  EXPECT_GT(x[kKey - 15].item<double>(), 0.02);
  EXPECT_LT(largest(x.diff()) * 30, 0.3) << "nothing stands out";
  EXPECT_TRUE(torch::equal(out.rotations.select(1, 15), clip.rotations.select(1, 15))) << "the head has no part in it";
}

TEST(RefineGenerated, WhatAPredictionMissesByMuchIsMadeUpForAsARotation) {
  const Clip clip = standing();
  Clip keyed = clip;
  keyed.rotations = clip.rotations.clone();
  keyed.rotations[0][4][0] = 150 * M_PI / 180;
  pose(keyed);
  const Clip out = refine_generated(clip, keys_of(keyed, {0}, {1}));
  const Tensor bend = out.rotations.select(1, 4).select(1, 0) * (180 / M_PI);
  EXPECT_NEAR(bend[0].item<double>(), 150, 0.1);
  EXPECT_LT(largest(bend.diff()), 1.5 * 150 / 20.0) << "degrees a frame";
  EXPECT_LT(std::abs(bend[60].item<double>()), 20);
  EXPECT_LT(largest(out.rotations.select(1, 4).slice(1, 1)), 1e-3) << "about one axis all along";
}

TEST(RefineGenerated, AHandGoesWhereTheArmReaches) {
  const Clip clip = standing(), keyed = reaching(clip, 0.6, {0.F, 0.F, 0.F});
  const Clip out = refine_generated(clip, keys_of(keyed, {0, kKey, 60}, {1, 0, 1}, {0, 20}));
  EXPECT_GT(missed(clip, keyed, 20), 0.2);
  EXPECT_LT(missed(out, keyed, 20), 1e-3);
  EXPECT_LT(missed(out, keyed, 0), 1e-3);
  EXPECT_TRUE(torch::equal(out.joints[0], clip.joints[0]));
  EXPECT_TRUE(torch::equal(out.joints[60], clip.joints[60]));
  expect_posed(out);
}

TEST(RefineGenerated, APointOfTheHandGoesThere) {
  const Clip clip = standing(), keyed = reaching(clip, 0.6, {0.F, 0.F, 0.F});
  KeyPoses keys = keys_of(clip, {0, 60}, {1, 1});
  JointTarget target = joint_targets(keyed, kKey, kKey, {20})[0];
  target.offset = {0.1, 0, 0};
  keys.targets = {target};
  const Clip out = refine_generated(clip, keys);
  EXPECT_NEAR(missed(out, keyed, 20), 0.1, 1e-3) << "the wrist is as far from there as the point from the wrist";
  target.sigma = {0.0003, std::numeric_limits<double>::infinity(), 0.0003};
  target.place.y() += 5;
  keys.targets = {target};
  const Clip beside = refine_generated(clip, keys);
  EXPECT_LT((beside.joints[kKey][20] - keyed.joints[kKey][20]).norm().item<double>(), 0.6) << "any height will do";
}

TEST(RefineGenerated, TheTrunkLeansForAHandOnAPelvisThatStays) {
  const Clip clip = standing(), keyed = reaching(clip, 1.2, {0.F, 0.F, 0.F}, 0.6);
  const Clip out = refine_generated(clip, keys_of(keyed, {0, kKey, 60}, {1, 0, 1}, {0, 20}));
  EXPECT_LT(missed(out, keyed, 20), 2e-3);
  EXPECT_LT(missed(out, keyed, 0), 1e-3) << "the pelvis is where it was given";
  EXPECT_GT((out.joints[kKey][15] - clip.joints[kKey][15])[2].item<double>(), 0.05) << "the head comes along";
  EXPECT_LT(largest(out.joints[kKey].index_select(0, torch::tensor({7, 8, 10, 11})) -
                    clip.joints[kKey].index_select(0, torch::tensor({7, 8, 10, 11}))),
            1e-3);
  expect_posed(out);
}

TEST(RefineGenerated, TheBodyComesAlongWhereTheRootIsFree) {
  const Clip clip = standing(), keyed = reaching(clip, 0.3, {0.F, 0.F, 1.5F});
  const Clip out = refine_generated(clip, keys_of(keyed, {0, kKey, 60}, {1, 0, 1}, {20}));
  EXPECT_LT(missed(out, keyed, 20), 2e-3);
  EXPECT_GT(out.joints[kKey][0][2].item<double>(), 0.5);
  EXPECT_LT(largest(joint_positions(out.skeleton, out.rotations, out.trans) - out.joints), 1e-4);
}

TEST(RefineGenerated, NoisyKeysCountByTheirNoise) {
  // The network's motion interpolates keys with noise, every third frame.
  Clip truth = read_clip(std::string(INHABIT_SOURCE_DIR) + "/examples/data/walk.npz");
  pose(truth);
  torch::manual_seed(3);
  std::vector<int64_t> frames;
  for (int64_t t = 0; t < truth.frames(); t += 3) frames.push_back(t);
  const auto count = static_cast<int64_t>(frames.size());
  Clip noise = frames_at(truth, frames);
  noise.rotations = noise.rotations + torch::randn_like(noise.rotations) * (M_PI / 180);
  noise.trans = noise.trans + torch::randn_like(noise.trans) * 0.01;
  pose(noise);
  Clip motion = truth;
  motion.rotations = truth.rotations.clone();
  motion.trans = truth.trans.clone();
  for (int64_t t = 0; t < truth.frames(); ++t) {
    const int64_t k = std::min(t / 3, count - 1), next = std::min(k + 1, count - 1);
    const double part = k == next ? 0 : static_cast<double>(t - 3 * k) / 3;
    motion.rotations[t] = noise.rotations[k] * (1 - part) + noise.rotations[next] * part;
    motion.trans[t] = noise.trans[k] * (1 - part) + noise.trans[next] * part;
  }
  pose(motion);
  const KeyPoses keys{frames, noise, std::vector<char>(frames.size(), 0), {}};
  GeneratedOptions options;
  options.smooth = true;
  const Clip out = refine_generated(motion, keys, options);
  const auto error = [&](const Clip& c) { return (c.joints - truth.joints).norm(2, {2}).mean().item<double>(); };
  EXPECT_LT(error(out), 0.85 * error(motion));
  const auto jerk = [](const Clip& c) { return c.joints.diff(3, 0).norm(2, {2}).mean().item<double>(); };
  EXPECT_LT(jerk(out), 1.2 * jerk(truth));
  EXPECT_GT(jerk(motion), 2 * jerk(truth));
  options.noise = 0.01;  // keys that are trusted are met
  const Clip met = refine_generated(motion, keys, options);
  EXPECT_LT(largest(frames_at(met, frames).joints - noise.joints), 2e-3);
}

TEST(RefineGenerated, RefusesKeysThatDoNotFit) {
  const Clip clip = standing();
  EXPECT_THROW(refine_generated(clip, keys_of(clip, {0, 60}, {1})), Error);
  EXPECT_THROW(refine_generated(clip, {{0, 61}, frames_at(clip, {0, 60}), {1, 1}, {}}), Error);
  KeyPoses aside = keys_of(clip, {0, 60}, {1, 1});
  aside.targets.push_back({30, 22, {0, 1, 0}});
  EXPECT_THROW(refine_generated(clip, aside), Error);
  aside.targets[0] = {61, 20, {0, 1, 0}};
  EXPECT_THROW(refine_generated(clip, aside), Error);
  Clip positions = clip;
  positions.rotations = Tensor();
  EXPECT_THROW(refine_generated(positions, keys_of(clip, {0, 60}, {1, 1})), Error);
  EXPECT_LT(largest(refine_generated(clip, {}).joints - clip.joints), 1e-5) << "nothing asked for, nothing changed";
}

}  // namespace
}  // namespace inhabit::refine
