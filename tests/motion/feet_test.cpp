// Protects feet that stand: a sliding foot is held, what is fixed stays, bones keep their lengths, and motion whose
// feet stand already is hardly touched.
#include "inhabit/motion/feet.h"

#include <gtest/gtest.h>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/io/files.h"
#include "inhabit/metrics/foot_skating.h"
#include "inhabit/motion/canonical.h"
#include "largest.h"

namespace inhabit {
namespace {

using torch::Tensor;

/// Stands with bent knees, balls of the feet 2 cm above the floor, and drifts along x by `drift` metres a frame.
Clip drifting(int64_t frames, double drift) {
  Clip clip;
  clip.skeleton = builtin_body().skeleton;
  clip.rotations = torch::zeros({frames, clip.skeleton.size(), 3});
  for (const auto& [joint, bend] : {std::pair(1, -0.5), {2, -0.5}, {4, 1.0}, {5, 1.0}, {7, -0.5}, {8, -0.5}})
    clip.rotations.select(1, joint).select(1, 0).fill_(bend);
  clip.trans = torch::zeros({frames, 3});
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  clip.trans.select(1, 1).sub_(clip.joints[0][10][1].item<double>() - 0.02);
  clip.trans.select(1, 0).add_(torch::arange(frames) * drift);
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

Clip walk() { return read_clip(std::string(INHABIT_SOURCE_DIR) + "/examples/data/walk.npz"); }

TEST(CleanFeet, AFootThatDriftsStands) {
  const Clip clip = drifting(20, 0.005), held = clean_feet(clip, {});
  for (const int ball : {10, 11}) {
    const Tensor path = held.joints.select(1, ball);
    EXPECT_LT(largest(path - path.mean(0, true)), 1e-4) << ball;
    EXPECT_LT(largest(path.select(1, 1) - 0.02), 1e-3) << "feet keep their height";
  }
  EXPECT_TRUE(torch::equal(held.trans, clip.trans)) << "the body goes on";
  EXPECT_LT(largest(joint_positions(held.skeleton, held.rotations, held.trans) - held.joints), 1e-4)
      << "joints are those of the poses, so that bones keep their lengths";
  const auto foot = [](const Clip& c) { return c.joints.select(1, 10) - c.joints.select(1, 7); };
  EXPECT_LT(largest(foot(held) - foot(clip)), 1e-4) << "feet point where they did";
}

TEST(CleanFeet, JointsBesideTheSkeletonsMoveAsThoseDo) {
  const Clip clip = drifting(20, 0.005);
  Clip beside = clip;
  beside.joints = clip.joints + torch::tensor({0.004, 0.002, -0.003});
  const Tensor moves = clean_feet(clip, {}).joints - clip.joints,
               others = clean_feet(beside, {}).joints - beside.joints;
  EXPECT_GT(largest(moves), 0.02);
  EXPECT_LT(largest(moves - others), 1e-4);
}

TEST(CleanFeet, FramesOfAnyLength) {
  const Clip clip = drifting(40, 0.0025), half = drifting(20, 0.005);
  Clip quick = clip;
  quick.rate = 60;
  const Tensor every_other = torch::arange(0, 40, 2),
               held = clean_feet(quick, {8, 24}).joints.index_select(0, every_other);
  EXPECT_LT(largest(held - clean_feet(half, {4, 12}).joints), 2e-3);
}

TEST(CleanFeet, FixedFramesStayAndSayWhereAFootStands) {
  const Clip clip = drifting(20, 0.005), held = clean_feet(clip, {4, 12});
  for (const int64_t t : {4, 12}) {
    EXPECT_TRUE(torch::equal(held.rotations[t], clip.rotations[t])) << t;
    EXPECT_TRUE(torch::equal(held.joints[t], clip.joints[t])) << t;
  }
  const Tensor x = held.joints.select(1, 10).select(1, 0), was = clip.joints.select(1, 10).select(1, 0);
  EXPECT_LT(largest(x.slice(0, 0, 5) - was[4]), 1e-4);
  EXPECT_LT(largest(x.slice(0, 12) - was[12]), 1e-4);
  EXPECT_LT(largest(x.slice(0, 4, 13) - was.slice(0, 4, 13)), 1e-4) << "from one place to the other";
}

TEST(CleanFeet, FeetStayNearNoisyPoses) {
  const Clip clip = drifting(30, 0.008);  // 23 cm in all, so that the ends are held some 11 cm off
  const auto moved = [&](const Clip& held, int64_t frame) {
    return (held.joints[frame][10] - clip.joints[frame][10]).norm().item<double>();
  };
  EXPECT_GT(moved(clean_feet(clip, {}), 3), 0.06);
  const Clip near = clean_feet(clip, {}, 0, {3, 15, 26}, 0.03);
  for (const int64_t frame : {3, 15, 26}) EXPECT_LT(moved(near, frame), 0.0301) << frame;
  const Clip far = clean_feet(clip, {}, 0, {3, 15, 26}, 0.2);
  EXPECT_LT(largest(far.joints - clean_feet(clip, {}).joints), 1e-6) << "what is near enough is left alone";
}

TEST(CleanFeet, AFixedFrameBesideAStanceIsComeToSmoothly) {
  // Drifts for ten frames and goes on quickly, in the air, in a fixed one.
  Clip clip = drifting(20, 0.015);
  clip.trans.slice(0, 10).select(1, 0).add_(torch::arange(1, 11) * 0.05);
  clip.trans.slice(0, 10).select(1, 1).add_(0.1);
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  const Clip held = clean_feet(clip, {10});
  EXPECT_TRUE(torch::equal(held.joints[10], clip.joints[10]));
  const Tensor moves = (held.joints - clip.joints).select(1, 10).select(1, 0);
  EXPECT_GT(largest(moves), 0.005) << "the foot is held where that is not near";
  EXPECT_LT(largest(moves.diff()), 0.02) << "and nothing jumps";
}

TEST(CleanFeet, APersonWhoGlidesMakesSteps) {
  for (const double speed : {0.5, 1.5}) {
    const Clip clip = drifting(90, speed / 30), held = clean_feet(clip, {0, 89});
    EXPECT_GT(foot_skating(clip, 0.05, 0.01).fraction(), 0.99);
    EXPECT_LT(foot_skating(held).fraction(), 0.1) << speed;
    std::array<int, 2> standing = {0, 0};
    int both_up = 0;
    for (int64_t t = 0; t + 1 < 90; ++t) {
      int up = 0;
      for (const int side : {0, 1}) {
        const Tensor here = held.joints[t][10 + side], next = held.joints[t + 1][10 + side];
        standing[static_cast<size_t>(side)] += (next - here).norm().item<double>() < 0.005 ? 1 : 0;
        up += here[1].item<double>() > 0.06 ? 1 : 0;
        EXPECT_LT(here[1].item<double>(), 0.15) << "no foot is left behind";
      }
      both_up += up == 2 ? 1 : 0;
    }
    for (const int frames : standing) EXPECT_GT(frames, speed < 1 ? 25 : 10) << speed;
    EXPECT_EQ(both_up, 0) << speed;
    for (const int64_t t : {0, 89}) EXPECT_TRUE(torch::equal(held.joints[t], clip.joints[t]));
  }
}

TEST(CleanFeet, AFootThatGoesIsLiftedAndNoneIsUnderTheFloor) {
  Clip clip = walk();
  clip.trans = clip.trans.clone();
  clip.trans.select(1, 1).sub_(0.04);
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  const Clip held = clean_feet(clip, {});
  EXPECT_GT(foot_skating(clip).fraction(), 0.1);
  EXPECT_LT(foot_skating(held).fraction(), 0.05);
  EXPECT_LT(clip.joints.slice(1, 10, 12).select(2, 1).min().item<double>(), -0.015);
  EXPECT_GT(held.joints.slice(1, 10, 12).select(2, 1).min().item<double>(), -0.001);
  const Clip high = transformed(clip, {0, {0, 1, 0}}), high_held = clean_feet(high, {}, 1);
  EXPECT_LT(largest(high_held.joints.select(2, 1) - 1 - held.joints.select(2, 1)), 1e-4) << "floors of any height";
}

TEST(CleanFeet, WalkingOnFeetThatStandIsHardlyTouched) {
  const Clip clip = walk(), held = clean_feet(clip, {});
  EXPECT_LT((held.joints - clip.joints).norm(2, {2}).mean().item<double>(), 0.005);
  EXPECT_LE(foot_skating(held).fraction(), foot_skating(clip).fraction());
}

TEST(CleanFeet, AWalkMadeToSlideSkatesLess) {
  Clip clip = walk();
  const Tensor sway = 0.14 * torch::sin(torch::arange(clip.frames()) * 0.25);  // up to 1 m/s
  clip.trans = clip.trans.clone();
  clip.trans.select(1, 0).add_(sway);
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  const double before = foot_skating(clip).fraction(), after = foot_skating(clean_feet(clip, {})).fraction();
  EXPECT_GT(before, 0.1);
  EXPECT_LT(after, before / 2);
  const Tensor acceleration = clean_feet(clip, {}).joints.diff(2, 0).norm(2, {2});
  EXPECT_LT(acceleration.max().item<double>(), 2 * clip.joints.diff(2, 0).norm(2, {2}).max().item<double>())
      << "and nothing jumps";
}

}  // namespace
}  // namespace inhabit
