// Protects refinement as a whole: noise goes and the recording comes back, feet stop sliding, what is kept is kept to
// the bit, long motions are as good as short ones, and the settings of the chair paper's Eq. 7 and 8 are this solver's.
#include "inhabit/refine/refine_clip.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/io/files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/math/quaternion.h"
#include "inhabit/metrics/collision.h"
#include "inhabit/metrics/foot_skating.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/refine/scene_terms.h"
#include "inhabit/refine/solve.h"
#include "inhabit/refine/terms.h"
#include "inhabit/refine/trajectory.h"
#include "inhabit/scene/shapes.h"
#include "largest.h"
#include "refusal_of.h"
#include "shared.h"

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;
using torch::Tensor;

Clip walk() {
  Clip clip = read_clip(std::string(INHABIT_SOURCE_DIR) + "/examples/data/walk.npz");
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

/// A degree on every component of the rotations, a centimetre on the root.
Clip noisy(const Clip& clip, double level) {
  torch::manual_seed(4);
  Clip out = clip;
  out.rotations = clip.rotations + torch::randn_like(clip.rotations) * (level * M_PI / 180);
  out.trans = clip.trans + torch::randn_like(clip.trans) * (0.01 * level);
  out.joints = joint_positions(out.skeleton, out.rotations, out.trans);
  return out;
}

double distance(const Clip& a, const Clip& b) { return (a.joints - b.joints).norm(2, {2}).mean().item<double>(); }
double jerk(const Clip& clip) { return clip.joints.diff(3, 0).norm(2, {2}).mean().item<double>(); }

TEST(Refine, NoiseGoesAndFeetStand) {
  const Clip truth = walk(), input = noisy(truth, 1);
  const Result result = refine(input, {});
  EXPECT_NEAR(result.noise_rotations, M_PI / 180, 0.2 * M_PI / 180);
  EXPECT_NEAR(result.noise_root, 0.01, 0.003);
  EXPECT_LT(distance(result.clip, truth), 0.015);
  EXPECT_LT(distance(result.clip, truth), 0.7 * distance(input, truth));
  EXPECT_LT(foot_skating(result.clip).fraction(), 0.035);
  EXPECT_GT(foot_skating(input).fraction(), 0.4);
  EXPECT_LT(jerk(result.clip), 1.3 * jerk(truth));
  EXPECT_LT(largest(joint_positions(truth.skeleton, result.clip.rotations, result.clip.trans) - result.clip.joints),
            1e-4)
      << "bones keep their lengths";
}

TEST(Refine, ACleanRecordingStaysNearlyAsItIs) {
  const Clip truth = walk();
  const Result result = refine(truth, {});
  EXPECT_LT(result.moved, 0.008);
  EXPECT_GT(result.contacts, 4);
}

TEST(Refine, AMotionUnderTheFloorIsLifted) {
  const Clip truth = walk();
  Clip input = truth;
  input.trans = truth.trans - torch::tensor({0.F, 0.1F, 0.F});
  input.joints = joint_positions(input.skeleton, input.rotations, input.trans);
  const auto lowest = [](const Clip& clip) {
    return clip.joints.index_select(1, torch::tensor({10, 11})).select(2, 1).min().item<double>();
  };
  ASSERT_LT(lowest(input), -0.05);
  EXPECT_GT(lowest(refine(input, floor_scene()).clip), -0.01);
  EXPECT_NEAR(lowest(refine(truth, floor_scene()).clip), lowest(truth), 0.01);
}

TEST(Refine, SlidingFeetStand) {
  Clip input = walk();
  Tensor slide = torch::arange(input.frames()) * 0.003;  // the whole body drifts by 9 cm/s
  input.trans.select(1, 0).add_(slide);
  input.joints = joint_positions(input.skeleton, input.rotations, input.trans);
  const Result result = refine(input, {});
  // In the middle of a stance of the left foot.
  const auto moved = [](const Clip& clip) { return (clip.joints[16][10] - clip.joints[10][10]).norm().item<double>(); };
  EXPECT_GT(moved(input), 0.015);
  EXPECT_LT(moved(result.clip), 0.003);
}

TEST(Refine, FeetThatANetworkLetsGlideStand) {
  Clip input = walk();
  input.trans.select(1, 0).add_(torch::arange(input.frames()) * 0.01);  // 0.3 m/s more: no contact in a recording
  input.joints = joint_positions(input.skeleton, input.rotations, input.trans);
  Options generated;
  generated.generated = true;
  const auto moved = [](const Clip& clip) { return (clip.joints[16][10] - clip.joints[10][10]).norm().item<double>(); };
  EXPECT_GT(moved(input), 0.05);
  EXPECT_GT(moved(refine(input, {}).clip), 0.04);
  EXPECT_LT(moved(refine(input, {}, generated).clip), 0.02);
}

TEST(Refine, FeetStandWhereContactsArePredicted) {
  const Clip input = walk();
  Options options;
  options.feet = torch::zeros({input.frames(), 4});
  EXPECT_EQ(refine(input, {}, options).contacts, 0);
  options.feet.select(1, 2).slice(0, 10, 17).fill_(1);  // the left ball, while it stands
  EXPECT_EQ(refine(input, {}, options).contacts, 1);
  options.feet = torch::zeros({input.frames() - 1, 4});
  EXPECT_THAT(refusal_of([&] { refine(input, {}, options); }), testing::HasSubstr("four numbers for each frame"));
}

TEST(Refine, WhatIsKeptIsKept) {
  const Clip input = noisy(walk(), 1);
  Options options;
  add_kept("0,40,left_wrist", input, options);
  const Clip out = refine(input, {}, options).clip;
  for (const int64_t t : {0, 40}) {
    EXPECT_TRUE(torch::equal(out.rotations[t], input.rotations[t])) << t;
    EXPECT_TRUE(torch::equal(out.trans[t], input.trans[t])) << t;
    EXPECT_TRUE(torch::equal(out.joints[t], input.joints[t])) << t;
  }
  EXPECT_LT((out.joints.select(1, 20) - input.joints.select(1, 20)).norm(2, {1}).max().item<double>(), 6e-3);
  EXPECT_GT(distance(out, input), 0.005);
}

TEST(Refine, WhatToKeepIsReadOrRefused) {
  Options options;
  Clip clip = walk();
  clip.joints = torch::zeros({100, 22, 3});
  clip.skeleton.names[20] = "LeftHand";
  clip.skeleton.names[18] = "LeftForeArm";
  add_kept("every:30,head,5,LeftHand", clip, options);
  EXPECT_EQ(options.keep_frames, (std::vector<int64_t>{0, 30, 60, 90, 99, 5}));
  EXPECT_EQ(options.keep_joints, (std::vector<int>{15, 20})) << "by standard names and the file's";
  EXPECT_THAT(refusal_of([&] { add_kept("elbow", clip, options); }),
              testing::AllOf(testing::HasSubstr("'elbow'"), testing::HasSubstr("left_elbow"),
                             testing::HasSubstr("LeftForeArm")));
  EXPECT_THROW(add_kept("every:0", clip, options), Error);
  EXPECT_THROW(add_kept("-3", clip, options), Error);
  Options beyond;
  beyond.keep_frames = {90};
  EXPECT_THROW(refine(walk(), {}, beyond), Error);
}

TEST(Refine, LongMotionsInWindowsAreSmoothAcrossThem) {
  const Clip once = walk();
  std::vector<int64_t> back_and_forth;
  for (int64_t t = 0; t < 700; ++t) back_and_forth.push_back(std::min(t % 178, 178 - t % 178));
  Clip truth = frames_at(once, back_and_forth);
  const Result result = refine(noisy(truth, 1), {});
  const Tensor error = (result.clip.joints - truth.joints).norm(2, {2}).mean(1),
               jerks = result.clip.joints.diff(3, 0).norm(2, {2}).mean(1);
  EXPECT_LT(error.mean().item<double>(), 0.016);
  // Four windows, which overlap by 30 frames: where one begins, what it keeps ends, the one before ends.
  Tensor elsewhere = jerks.clone();
  std::vector<int64_t> seams;
  for (int64_t window = 1; window < 4; ++window)
    for (const int64_t after : {0, 15, 30}) seams.push_back((700 - 30) * window / 4 + after);
  for (const int64_t seam : seams) elsewhere.slice(0, seam - 4, seam + 4).zero_();
  for (const int64_t seam : seams)
    EXPECT_LT(jerks.slice(0, seam - 4, seam + 4).max().item<double>(), 1.5 * elsewhere.max().item<double>()) << seam;
  EXPECT_LT(jerks.max().item<double>(), 0.05);
}

TEST(Refine, ShortMotionsAreNoSpecialCase) {
  for (const int64_t frames : {1, 2, 3, 5}) {
    const Clip input = slice(noisy(walk(), 1), 0, frames);
    EXPECT_TRUE(refine(input, {}).clip.joints.isfinite().all().item<bool>()) << frames;
  }
}

TEST(Refine, NobodyIsInsideAnything) {
  const std::string data = std::string(INHABIT_SOURCE_DIR) + "/examples/data/";
  const Clip truth = slice(read_clip(data + "sit.npz"), 0, 150), input = noisy(truth, 1);
  const Scene scene = read_scene_file(data + "sit_room.glb", {}).scene;
  const CollisionMeter meter(builtin_body(), scene);
  const Clip out = refine(input, scene).clip;
  EXPECT_LT(meter.measure(out).penetration(), 0.01);
}

TEST(Refine, ContinuationsThatShareTheirSceneAreAsEachAlone) {
  const Clip clip = walk(), past = slice(clip, 0, 30);
  Clip here = slice(noisy(clip, 0.5), 30, 60), away = here;
  away.trans = here.trans + torch::tensor({6.F, 0.F, 0.F});  // out of the room
  away.joints = here.joints + torch::tensor({6.F, 0.F, 0.F});
  const Tensor middle = here.joints.select(1, 0).mean(0);
  const double x = middle[0].item<double>(), z = middle[2].item<double>();
  MeshBuilder walls, block;
  walls.box({x, 1.5, z}, {3, 1.5, 3});  // looks outwards: it is turned around who is in it, and no other
  block.box({x + 0.3, 0.5, z}, {0.2, 0.5, 0.2});
  Scene scene = floor_scene();
  scene.meshes.push_back(walls.mesh("room", {1, 1, 1}));
  scene.meshes.push_back(block.mesh("block", {1, 1, 1}));
  const SharedSurroundings shared(scene);
  for (const Clip& future : {here, away, here}) {
    const Clip alone = refine_continuation(past, future, SharedSurroundings(scene)),
               together = refine_continuation(past, future, shared);
    EXPECT_EQ(together.frames(), 30);
    EXPECT_TRUE(torch::equal(together.joints, alone.joints));
    EXPECT_TRUE(torch::equal(together.rotations, alone.rotations));
  }
  EXPECT_EQ(&shared.around(here.root_path()), &shared.around(past.root_path())) << "made once";
  EXPECT_NE(&shared.around(here.root_path()), &shared.around(away.root_path()));
}

// The table of docs/refinement.md.
TEST(Refine, RecordingsWithNoise) {
  if (shared_folder().empty()) GTEST_SKIP() << "needs the recordings of shared/data";
  double skating = 0, error = 0;
  const std::vector<std::string> actions = {"walking", "running", "basketball", "soccer", "washwindow", "jumping"};
  std::printf(
      "recording     frames  noise (mm)  error (mm)  moved (mm)  skating (%%): true, noisy, refined  jerk / true\n");
  for (const std::string& action : actions) {
    const std::string path = shared_folder() + "/data/cmu/test/" + action + "/" + action + "_1.txt";
    Clip truth = resample(retarget(read_clip(path), path), 30);
    // Skating is told from heights over y = 0: the recording is put there.
    const double lowest = truth.joints.slice(1, 10, 12).select(2, 1).min().item<double>();
    truth.trans.select(1, 1).sub_(lowest - 0.02);
    truth.joints = joint_positions(truth.skeleton, truth.rotations, truth.trans);
    const Clip input = noisy(truth, 1);
    const Result result = refine(input, {});
    std::printf("%-12s %7ld %11.1f %11.1f %11.1f %14.1f %6.1f %7.1f %16.2f\n", action.c_str(), long{truth.frames()},
                1e3 * distance(input, truth), 1e3 * distance(result.clip, truth), 1e3 * result.moved,
                100 * foot_skating(truth).fraction(), 100 * foot_skating(input).fraction(),
                100 * foot_skating(result.clip).fraction(), jerk(result.clip) / jerk(truth));
    skating += foot_skating(result.clip).fraction() / static_cast<double>(actions.size());
    error += distance(result.clip, truth) / static_cast<double>(actions.size());
  }
  std::printf("mean: error %.1f mm, skating %.1f %%\n", 1e3 * error, 100 * skating);
  EXPECT_LT(skating, 0.02);
  EXPECT_LT(error, 0.02);
}

/// Eq. 7 and 8 by themselves, on joint rotations and positions, rounding of the norm left out.
double chair_objective(const Trajectory& motion, const Bones& bones, double rate,
                       const std::vector<PlaceTerm>& targets) {
  const Poses poses = posed(bones, motion);
  double sum = 0;
  for (size_t t = 0; t + 1 < motion.size(); ++t)
    for (size_t j = 0; j < motion[t].local.size(); ++j)
      sum += axis_angle_of(motion[t].local[j].conjugate() * motion[t + 1].local[j]).squaredNorm();
  for (size_t t = 1; t + 1 < motion.size(); ++t)
    for (size_t j = 0; j < motion[t].local.size(); ++j)
      sum += rate * rate * (poses[t + 1].positions[j] - 2 * poses[t].positions[j] + poses[t - 1].positions[j]).norm();
  for (const PlaceTerm& p : targets)
    sum += (poses[static_cast<size_t>(p.frame)].positions[static_cast<size_t>(p.point)] - p.target).squaredNorm();
  return sum;
}

TEST(Refine, TheChairPapersObjectiveIsASetting) {
  const Clip input = slice(noisy(walk(), 0.5), 0, 40);
  Problem problem;
  problem.bones = bones_of(input.skeleton);
  problem.points = joint_points(kStandardJoints);
  problem.start = trajectory_of(input);
  problem.rate = input.rate;
  // Eq. 7: squared differences of rotations, unsquared norms of accelerations; Eq. 8: means over the contacts.
  problem.smoothness.push_back({1, 0, 2 / (input.rate * input.rate), {}, false, {}});
  problem.smoothness.push_back({2, 1, 0, {Loss::Kind::norm, 1e-6}, false, {}});
  const Poses before = posed(problem.bones, problem.start);
  for (const int joint : {7, 10}) {
    Vector3d mean = Vector3d::Zero();
    for (size_t t = 8; t < 18; ++t) mean += before[t].positions[static_cast<size_t>(joint)] / 10;
    for (int64_t t = 8; t < 18; ++t) problem.places.push_back({t, joint, mean, Vector3d::Constant(2), {}});
  }
  const auto objective = [&](const Trajectory& t) {
    return chair_objective(t, problem.bones, problem.rate, problem.places);
  };
  EXPECT_NEAR(cost_of(problem, problem.start), objective(problem.start), 1e-2);
  const Solution solution = solve(problem, {30, 1e-6});
  EXPECT_NEAR(solution.cost, objective(solution.trajectory), 1e-2);
  EXPECT_LT(objective(solution.trajectory), 0.3 * objective(problem.start));
}

}  // namespace
}  // namespace inhabit::refine
