#include "inhabit/body/kinematics.h"

#include <gtest/gtest.h>

#include "inhabit/body/bones.h"
#include "inhabit/error.h"
#include "inhabit/math/rotation.h"
#include "largest.h"

namespace inhabit {
namespace {

using torch::Tensor;

TEST(Kinematics, IdentityRotationsGiveTheRestPose) {
  const Skeleton& s = builtin_body().skeleton;
  const Tensor joints = joint_positions(s, torch::zeros({2, 22, 3}), torch::zeros({2, 3}));
  EXPECT_LT(largest(joints[1] - s.rest_joints()), 1e-6);
  EXPECT_LT(largest(s.rest_joints() - builtin_body().joint_template), 1e-6);
}

TEST(Kinematics, ChainOfTwoRotationsHasTheClosedForm) {
  const std::vector<int> parents = {-1, 0, 1};
  const Tensor offsets = torch::tensor({0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0}, torch::kDouble).view({3, 3});
  Tensor v = torch::zeros({3, 3}, torch::kDouble);
  v[0][2] = 0.4;
  v[1][2] = 0.9;
  const Pose pose =
      forward_kinematics(parents, offsets, axis_angle_to_matrix(v), torch::tensor({5.0, 0.0, 0.0}, torch::kDouble));
  EXPECT_NEAR(pose.positions[2][0].item<double>(), 5 + std::cos(0.4) + std::cos(1.3), 1e-12);
  EXPECT_NEAR(pose.positions[2][1].item<double>(), std::sin(0.4) + std::sin(1.3), 1e-12);
}

TEST(Kinematics, PlainAndDifferentiableAndEigenPathsAgree) {
  torch::manual_seed(1);
  const Skeleton& s = builtin_body().skeleton;
  const Tensor v = torch::randn({4, 22, 3}, torch::kDouble), trans = torch::randn({4, 3}, torch::kDouble);
  const Tensor offsets = s.offsets.to(torch::kDouble);
  const Pose plain = forward_kinematics(s.parents, offsets, axis_angle_to_matrix(v), trans);
  const Pose tracked =
      forward_kinematics(s.parents, offsets, axis_angle_to_matrix(v.clone().requires_grad_(true)), trans);
  EXPECT_LT(largest(plain.positions - tracked.positions), 1e-13);
  EXPECT_LT(largest(plain.rotations - tracked.rotations), 1e-13);

  BonesPose pose;
  pose_bones(bones_of(s), local_quaternions(v[2]),
             {trans[2][0].item<double>(), trans[2][1].item<double>(), trans[2][2].item<double>()}, pose);
  for (int j = 0; j < 22; ++j)
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(pose.positions[j][i], plain.positions[2][j][i].item<double>(), 1e-12);
}

TEST(Kinematics, GradientsAgreeWithDifferences) {
  torch::manual_seed(2);
  const Skeleton& s = builtin_body().skeleton;
  const Tensor weights = torch::randn({22, 3}, torch::kDouble);
  const auto f = [&](const Tensor& v, const Tensor& trans, const Tensor& offsets) {
    return (forward_kinematics(s.parents, offsets, axis_angle_to_matrix(v), trans).positions * weights).sum();
  };
  for (double size : {0.0, 0.7}) {
    const std::vector<Tensor> x = {torch::randn({22, 3}, torch::kDouble) * size, torch::randn({3}, torch::kDouble),
                                   s.offsets.to(torch::kDouble)};
    for (size_t which = 0; which < x.size(); ++which) {
      std::vector<Tensor> in = {x[0].clone(), x[1].clone(), x[2].clone()};
      in[which].requires_grad_(true);
      f(in[0], in[1], in[2]).backward();
      const Tensor analytic = in[which].grad().view(-1);
      for (int64_t i = 0; i < analytic.size(0); i += 3) {
        std::vector<Tensor> plus = {x[0].clone(), x[1].clone(), x[2].clone()},
                            minus = {x[0].clone(), x[1].clone(), x[2].clone()};
        plus[which].view(-1)[i] += 1e-6;
        minus[which].view(-1)[i] -= 1e-6;
        const double numeric = (f(plus[0], plus[1], plus[2]) - f(minus[0], minus[1], minus[2])).item<double>() / 2e-6;
        EXPECT_NEAR(analytic[i].item<double>(), numeric, 1e-7);
      }
    }
  }
}

TEST(Kinematics, BatchesOfSkeletonsBroadcast) {
  const Skeleton& s = builtin_body().skeleton;
  const Tensor rotations = axis_angle_to_matrix(torch::randn({2, 3, 22, 3}) * 0.3);
  const Tensor trans = torch::zeros({2, 3, 3});
  const Tensor a = forward_kinematics(s.parents, s.offsets, rotations, trans).positions;
  const Tensor b = forward_kinematics(s.parents, s.offsets.expand({2, 3, 22, 3}), rotations, trans).positions;
  const Tensor c = forward_kinematics(s.parents, s.offsets.view({1, 1, 22, 3}), rotations, trans).positions;
  EXPECT_LT(largest(a - b), 1e-7);
  EXPECT_LT(largest(a - c), 1e-6);
}

TEST(Kinematics, WrongShapesAreRefused) {
  const Skeleton& s = builtin_body().skeleton;
  EXPECT_THROW(joint_positions(s, torch::zeros({2, 21, 3}), torch::zeros({2, 3})), Error);
  EXPECT_THROW(joint_positions(s, torch::zeros({2, 22, 3}), torch::zeros({3})), Error);
}

}  // namespace
}  // namespace inhabit
