#include "inhabit/body/fit.h"

#include <gtest/gtest.h>

#include <chrono>

#include "inhabit/body/kinematics.h"
#include "inhabit/body/proportions.h"
#include "inhabit/error.h"
#include "inhabit/math/rotation.h"

namespace inhabit {
namespace {

using torch::Tensor;

/// A walk-like motion (T, 22, 3) of a body: legs and arms swing, knees and elbows bend, the trunk turns, the path
/// curves.
void walk(int64_t frames, Tensor& rotations, Tensor& trans) {
  rotations = torch::zeros({frames, 22, 3});
  trans = torch::zeros({frames, 3});
  auto r = rotations.accessor<float, 3>();
  auto x = trans.accessor<float, 2>();
  for (int64_t t = 0; t < frames; ++t) {
    const float phase = 0.2F * static_cast<float>(t), s = std::sin(phase), c = std::cos(phase);
    r[t][0][1] = 0.02F * static_cast<float>(t);
    r[t][1][0] = -0.4F * s;
    r[t][2][0] = 0.4F * s;
    r[t][4][0] = 0.5F + 0.45F * c;
    r[t][5][0] = 0.5F - 0.45F * c;
    r[t][7][0] = -0.15F * s;
    r[t][3][0] = 0.08F;
    r[t][6][1] = 0.1F * s;
    r[t][9][1] = 0.05F * s;
    r[t][12][1] = -0.2F * s;
    r[t][13][2] = -0.1F;
    r[t][14][2] = 0.1F;
    r[t][16][2] = -1.2F;
    r[t][16][0] = 0.3F * s;
    r[t][17][2] = 1.2F;
    r[t][17][0] = -0.3F * s;
    r[t][18][1] = -0.4F - 0.2F * s;
    r[t][19][1] = 0.9F;
    x[t][0] = 0.3F * s;
    x[t][1] = 0.94F;
    x[t][2] = 0.035F * static_cast<float>(t);
  }
}

TEST(Fit, FindsTheMotionOfTheSameSkeleton) {
  Tensor rotations, trans;
  walk(90, rotations, trans);
  const BodyModel& body = builtin_body();
  const Tensor joints = joint_positions(body.skeleton, rotations, trans);
  const auto begin = std::chrono::steady_clock::now();
  const BodyFit fit = fit_body(body, joints);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  RecordProperty("seconds", std::to_string(seconds));
  RecordProperty("mean_error_mm", std::to_string(fit.mean_error * 1000));
  std::printf("90 frames: %.0f ms, mean error %.3f mm\n", seconds * 1000, fit.mean_error * 1000);
  EXPECT_LT(fit.mean_error, 0.002);
  const Tensor again = joint_positions(body.skeleton, fit.rotations, fit.trans);
  EXPECT_NEAR((again - joints).norm(2, -1).mean().item<double>(), fit.mean_error, 1e-5);
  // Knees and elbows come back as hinges, and so do the rotations above them.
  const Tensor difference = (fit.rotations - rotations).abs().mean(0);
  for (int j : {1, 2, 4, 5, 16, 17, 18, 19}) EXPECT_LT(difference[j].max().item<double>(), 0.15) << j;
}

TEST(Fit, StandsUpToWobblingBonesAndNoise) {
  Tensor rotations, trans;
  walk(60, rotations, trans);
  const BodyModel& body = builtin_body();
  torch::manual_seed(11);
  const Tensor joints = joint_positions(body.skeleton, rotations, trans);
  const Tensor noisy = joints + 0.01 * torch::randn_like(joints);
  const BodyFit fit = fit_body(body, noisy);
  const Tensor again = joint_positions(body.skeleton, fit.rotations, fit.trans);
  // Nearer to the truth than the noise is: a fixed skeleton cannot follow all of it.
  EXPECT_LT((again - joints).norm(2, -1).mean().item<double>(), (noisy - joints).norm(2, -1).mean().item<double>());
  EXPECT_LT((again - joints).norm(2, -1).max().item<double>(), 0.08);
  EXPECT_LT(fit.rotations.slice(0, 1).sub(fit.rotations.slice(0, 0, -1)).slice(1, 1).abs().max().item<double>(), 1.5);
}

TEST(Fit, KeepsWithinJointLimits) {
  Tensor rotations, trans;
  walk(30, rotations, trans);
  rotations.select(1, 4).select(1, 0).fill_(-0.6F);  // a knee bent the wrong way
  const BodyModel& body = builtin_body();
  const Tensor joints = joint_positions(body.skeleton, rotations, trans);
  const BodyFit fit = fit_body(body, joints);
  EXPECT_GT(fit.rotations.select(1, 4).select(1, 0).min().item<double>(), -0.45);
  EXPECT_LT(fit.mean_error, 0.05);
}

TEST(Fit, FindsTheShape) {
  Tensor rotations, trans;
  walk(40, rotations, trans);
  const BodyModel& body = builtin_body();
  Tensor betas = torch::zeros({kBuiltinBetas});
  betas[kStature] = 1.5;
  betas[kLegs] = -1;
  betas[kShoulders] = 1;
  const Skeleton shaped = shaped_skeleton(body, betas);
  FitOptions options;
  options.fit_shape = true;
  const BodyFit fit = fit_body(body, joint_positions(shaped, rotations, trans), options);
  EXPECT_LT(fit.mean_error, 0.005);
  const Tensor lengths = shaped_skeleton(body, fit.betas).offsets.norm(2, -1), truth = shaped.offsets.norm(2, -1);
  EXPECT_LT((lengths - truth).abs().max().item<double>(), 0.008);
}

TEST(Fit, AShapeStaysOneThatPeopleHave) {
  Tensor rotations, trans;
  walk(30, rotations, trans);
  const BodyModel& body = builtin_body();
  const Tensor joints = joint_positions(body.skeleton, rotations, trans) * 1.6;
  const Tensor betas = fit_shape(body, joints);
  EXPECT_LE(betas.abs().max().item<double>(), 3.0);
  EXPECT_GT(betas.abs().max().item<double>(), 2.9) << "this one is at the limit";
}

TEST(Fit, LongClipsAreSolvedInWindowsWithoutSeams) {
  Tensor rotations, trans;
  walk(300, rotations, trans);
  const BodyModel& body = builtin_body();
  const BodyFit fit = fit_body(body, joint_positions(body.skeleton, rotations, trans));
  EXPECT_EQ(fit.rotations.size(0), 300);
  EXPECT_LT(fit.mean_error, 0.002);
  EXPECT_LT((fit.rotations[240] - fit.rotations[239]).slice(0, 1).abs().max().item<double>(), 0.15);
}

/// Largest angle, radians, between rotation matrices (..., 3, 3).
double largest_angle(const Tensor& a, const Tensor& b) {
  return matrix_to_axis_angle(a.transpose(-1, -2).matmul(b)).norm(2, -1).max().item<double>();
}

/// Largest local rotation from a frame to the next, radians.
double fastest(const Tensor& rotations) {
  const Tensor r = axis_angle_to_matrix(rotations);
  return largest_angle(r.slice(0, 0, -1), r.slice(0, 1));
}

Tensor global_rotations_of(const BodyModel& body, const Tensor& rotations) {
  return forward_kinematics(body.skeleton.parents, body.skeleton.offsets, axis_angle_to_matrix(rotations),
                            torch::zeros({rotations.size(0), 3}))
      .rotations;
}

TEST(FitRotations, BringJointsOfTheSameBonesBack) {
  Tensor rotations, trans;
  walk(90, rotations, trans);
  const BodyModel& body = builtin_body();
  const Tensor joints = joint_positions(body.skeleton, rotations, trans);
  const BodyFit fit = fit_rotations(body, joints);
  EXPECT_LT(fit.max_error, 0.0005);
  const Tensor again = joint_positions(body.skeleton, fit.rotations, fit.trans);
  EXPECT_NEAR((again - joints).norm(2, -1).max().item<double>(), fit.max_error, 1e-5);
  // Limbs that bend have their twist from the bend, so thighs, shanks and arms are turned as they were.
  const Tensor off =
      matrix_to_axis_angle(
          global_rotations_of(body, rotations).transpose(-1, -2).matmul(global_rotations_of(body, fit.rotations)))
          .norm(2, -1)
          .mean(0);
  for (int j : {0, 1, 2, 4, 5, 9, 16, 17, 18, 19}) EXPECT_LT(off[j].item<double>(), 0.15) << j;
}

/// A person who spins twice a second, arms and legs through every direction, past the poles where the rotation from the
/// rest pose is ambiguous: nothing may rotate faster than it did.
TEST(FitRotations, DoNotFlipOnFastRotations) {
  constexpr int64_t kFrames = 240;
  Tensor rotations = torch::zeros({kFrames, 22, 3}), trans = torch::zeros({kFrames, 3});
  for (int64_t t = 0; t < kFrames; ++t) {
    const auto s = static_cast<float>(t) / 30.F;
    rotations[t][0][1] = 4 * static_cast<float>(M_PI) * s;
    for (const int j : {16, 17}) {
      rotations[t][j][2] = (j == 16 ? 1.F : -1.F) * static_cast<float>(M_PI) * (1 + 1.0F * std::sin(5 * s));
      rotations[t][j][1] = 0.3F * std::cos(3 * s);
    }
    for (const int j : {1, 2}) rotations[t][j][0] = -1.2F + 1.2F * std::sin(6 * s + static_cast<float>(j));
    for (const int j : {4, 5}) rotations[t][j][0] = 1.F - std::cos(7 * s);  // straight now and then
    for (const int j : {18, 19}) rotations[t][j][1] = (j == 18 ? -1.F : 1.F) * (1 - std::cos(4 * s));
  }
  const BodyModel& body = builtin_body();
  const BodyFit fit = fit_rotations(body, joint_positions(body.skeleton, rotations, trans));
  EXPECT_LT(fit.max_error, 0.001);
  EXPECT_LT(fastest(fit.rotations), std::max(0.6, 1.5 * fastest(rotations)));
}

TEST(FitRotations, OfStraightLimbsStayAtRest) {
  const BodyModel& body = builtin_body();
  Tensor rotations = torch::zeros({20, 22, 3}), trans = torch::zeros({20, 3});
  rotations.select(1, 16).select(1, 2).fill_(-1.3F);  // arms hang
  rotations.select(1, 17).select(1, 2).fill_(1.3F);
  torch::manual_seed(3);
  const Tensor joints = joint_positions(body.skeleton, rotations, trans),
               noisy = joints + 0.002 * torch::randn_like(joints);
  EXPECT_LT(largest_angle(global_rotations_of(body, rotations),
                          global_rotations_of(body, fit_rotations(body, joints).rotations)),
            0.1);
  EXPECT_LT(fastest(fit_rotations(body, noisy).rotations), 0.6);  // 2 mm of noise twist nothing about
}

/// What a network's joints are: bones that shrink and grow. Ankles and wrists stay, knees and elbows give way.
TEST(FitRotations, OfBonesThatWobbleStayNearTheJoints) {
  Tensor rotations, trans;
  walk(120, rotations, trans);
  const BodyModel& body = builtin_body();
  BodyModel wobbly = body;
  wobbly.skeleton.offsets = body.skeleton.offsets * 0.96;
  const Tensor joints = joint_positions(wobbly.skeleton, rotations, trans);
  const BodyFit closed = fit_rotations(body, joints), solved = fit_body(body, joints);
  EXPECT_LT(closed.mean_error, solved.mean_error + 0.005);
  EXPECT_LT(fastest(closed.rotations), 0.6);
}

TEST(FitRotations, EndWithNumbersWhereThereIsNoBody) {
  const BodyModel& body = builtin_body();
  for (const Tensor& joints :
       {torch::zeros({3, 22, 3}), torch::ones({1, 22, 3}) * torch::arange(22).view({1, 22, 1})}) {
    const BodyFit fit = fit_rotations(body, joints);
    EXPECT_TRUE(torch::isfinite(fit.rotations).all().item<bool>());
    EXPECT_TRUE(torch::isfinite(fit.trans).all().item<bool>());
  }
  // A skeleton with bones of no length, and joints that come together for a while.
  BodyModel flat = body;
  flat.skeleton.offsets = body.skeleton.offsets.clone();
  for (const int64_t j : {4, 7, 10, 18, 20, 12, 15}) flat.skeleton.offsets[j].zero_();
  flat.joint_template = flat.skeleton.rest_joints();
  Tensor rotations, trans;
  walk(30, rotations, trans);
  Tensor joints = joint_positions(body.skeleton, rotations, trans);
  EXPECT_TRUE(torch::isfinite(fit_rotations(flat, joints).rotations).all().item<bool>());
  joints.slice(0, 10, 20) = joints.slice(0, 10, 20).select(1, 0).unsqueeze(1);
  EXPECT_TRUE(torch::isfinite(fit_rotations(body, joints).rotations).all().item<bool>());
  EXPECT_THROW(fit_rotations(body, torch::zeros({3, 21, 3})), Error);
  EXPECT_THROW(fit_rotations(body, torch::zeros({0, 22, 3})), Error);
  EXPECT_THROW(fit_rotations(body, torch::full({1, 22, 3}, NAN)), Error);
}

TEST(Fit, RefusesWhatIsNoMotion) {
  EXPECT_THROW(fit_body(builtin_body(), torch::zeros({3, 21, 3})), Error);
  EXPECT_THROW(fit_body(builtin_body(), torch::zeros({0, 22, 3})), Error);
  EXPECT_THROW(fit_body(builtin_body(), torch::full({1, 22, 3}, NAN)), Error);
  // All joints in one place is no body, but must end and give numbers.
  const BodyFit fit = fit_body(builtin_body(), torch::zeros({2, 22, 3}));
  EXPECT_TRUE(torch::isfinite(fit.rotations).all().item<bool>());
}

}  // namespace
}  // namespace inhabit
