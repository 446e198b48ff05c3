#include "inhabit/math/rotation.h"

#include <gtest/gtest.h>

#include "inhabit/error.h"
#include "inhabit/math/quaternion.h"
#include "largest.h"

namespace inhabit {
namespace {

using torch::Tensor;

Tensor random_axis_angles(int64_t n, double most) {
  torch::manual_seed(7);
  const Tensor axis = torch::randn({n, 3}, torch::kDouble);
  return axis / axis.norm(2, -1, true) * torch::rand({n, 1}, torch::kDouble) * most;
}

/// Largest difference between autograd and central differences of a scalar function of x.
template <typename F>
double gradient_error(F f, const Tensor& x0) {
  Tensor x = x0.clone().requires_grad_(true);
  f(x).backward();
  const Tensor analytic = x.grad().clone();
  Tensor numeric = torch::zeros_like(x0);
  const double h = 1e-6;
  for (int64_t i = 0; i < x0.numel(); ++i) {
    Tensor plus = x0.clone(), minus = x0.clone();
    plus.view(-1)[i] += h;
    minus.view(-1)[i] -= h;
    numeric.view(-1)[i] = (f(plus) - f(minus)) / (2 * h);
  }
  return largest(analytic - numeric);
}

TEST(Rotation, AxisAngleGivesTheClosedFormRotations) {
  const double a = 0.7;
  const Tensor r = axis_angle_to_matrix(torch::tensor({0.0, 0.0, a}, torch::kDouble));
  const Tensor expected =
      torch::tensor({std::cos(a), -std::sin(a), 0.0, std::sin(a), std::cos(a), 0.0, 0.0, 0.0, 1.0}, torch::kDouble);
  EXPECT_LT(largest(r.flatten() - expected), 1e-15);
  EXPECT_LT(largest(axis_angle_to_matrix(torch::zeros({3}, torch::kDouble)) - torch::eye(3, torch::kDouble)), 1e-16);
}

TEST(Rotation, MatricesAreOrthonormalAndRightHanded) {
  const Tensor r = axis_angle_to_matrix(random_axis_angles(200, 6.0));
  EXPECT_LT(largest(r.matmul(r.transpose(-1, -2)) - torch::eye(3, torch::kDouble)), 1e-14);
  EXPECT_LT(largest(torch::det(r) - 1), 1e-14);
}

TEST(Rotation, YawRotatesPlusZTowardsPlusX) {
  const Tensor turned = torch::matmul(yaw_matrix(M_PI / 2), torch::tensor({0.F, 0.F, 1.F}));
  EXPECT_LT(largest(turned - torch::tensor({1.F, 0.F, 0.F})), 1e-6);
  const Tensor yaw = torch::tensor({{-3.0, -0.4, 0.0}, {0.7, 1.6, 3.1}}, torch::kDouble);
  const Tensor axis = torch::tensor({0.0, 1.0, 0.0}, torch::kDouble);
  EXPECT_LT(largest(yaw_matrix(yaw) - axis_angle_to_matrix(yaw.unsqueeze(-1) * axis)), 1e-14);
}

TEST(Rotation, YawIsToldByTheLeftSide) {
  const Tensor yaw = torch::tensor({{-3.0, -0.4, 0.0}, {0.7, 1.6, 3.1}}, torch::kDouble);
  const Tensor left = torch::matmul(yaw_matrix(yaw), torch::tensor({0.3, 0.1, 0.0}, torch::kDouble));
  EXPECT_LT(largest(yaw_of_left(left) - yaw), 1e-14);
  EXPECT_EQ(yaw_of_left(torch::tensor({-0.F, 1.F, 0.F})).item<float>(), 0);  // vertical
  EXPECT_THROW(yaw_of_left(torch::zeros({2})), Error);
}

TEST(Rotation, EveryRepresentationComesBack) {
  for (double most : {1e-9, 1e-4, 1e-2, 1.0, 3.14159}) {
    const Tensor v = random_axis_angles(200, most);
    const Tensor r = axis_angle_to_matrix(v);
    EXPECT_LT(largest(matrix_to_axis_angle(r) - v), 1e-8) << most;
    EXPECT_LT(largest(quaternion_to_matrix(matrix_to_quaternion(r)) - r), 1e-13) << most;
    EXPECT_LT(largest(rotation6d_to_matrix(matrix_to_rotation6d(r)) - r), 1e-13) << most;
  }
}

TEST(Rotation, RotationsBy180DegreesKeepTheirAxis) {
  const Tensor axes = torch::eye(3, torch::kDouble);
  const Tensor r = axis_angle_to_matrix(axes * M_PI);
  const Tensor v = matrix_to_axis_angle(r);
  EXPECT_LT(largest(v.norm(2, -1) - M_PI), 1e-7);
  EXPECT_LT(largest(axis_angle_to_matrix(v) - r), 1e-7);
}

TEST(Rotation, SinglePrecisionIsAccurateNearZeroAndPi) {
  for (double most : {1e-6, 1e-3, 1e-2, 3.14}) {
    const Tensor v = random_axis_angles(200, most).to(torch::kFloat);
    EXPECT_LT(largest(matrix_to_axis_angle(axis_angle_to_matrix(v)) - v), 2e-3 * std::max(1e-3, most)) << most;
  }
}

TEST(Rotation, GradientsAgreeWithDifferencesAlsoAtZero) {
  torch::manual_seed(3);
  const Tensor w = torch::randn({3, 3}, torch::kDouble), w4 = torch::randn({4}, torch::kDouble),
               w3 = torch::randn({3}, torch::kDouble);
  const std::vector<Tensor> points = {
      torch::zeros({3}, torch::kDouble), torch::tensor({1e-5, 0.0, -2e-5}, torch::kDouble),
      torch::tensor({0.009, 0.001, 0.004}, torch::kDouble), torch::tensor({0.8, -1.1, 0.4}, torch::kDouble),
      torch::tensor({0.1, 3.0, 0.2}, torch::kDouble)};
  for (const Tensor& x : points) {
    EXPECT_LT(gradient_error([&](const Tensor& v) { return (axis_angle_to_matrix(v) * w).sum(); }, x), 1e-8);
    EXPECT_LT(
        gradient_error([&](const Tensor& v) { return (matrix_to_quaternion(axis_angle_to_matrix(v)) * w4).sum(); }, x),
        1e-8);
    EXPECT_LT(
        gradient_error([&](const Tensor& v) { return (matrix_to_axis_angle(axis_angle_to_matrix(v)) * w3).sum(); }, x),
        1e-7);
  }
  const Tensor six = torch::tensor({0.9, 0.1, -0.3, 0.2, 1.2, 0.1}, torch::kDouble);
  EXPECT_LT(gradient_error([&](const Tensor& v) { return (rotation6d_to_matrix(v) * w).sum(); }, six), 1e-8);
  const Tensor q = torch::tensor({0.9, 0.1, -0.3, 0.2}, torch::kDouble);
  EXPECT_LT(gradient_error([&](const Tensor& v) { return (quaternion_to_matrix(v) * w).sum(); }, q), 1e-8);
}

TEST(Rotation, SlerpMovesAtConstantSpeedAlongTheShortArc) {
  const Tensor from = matrix_to_quaternion(axis_angle_to_matrix(torch::zeros({3}, torch::kDouble)));
  const Tensor axis = torch::tensor({0.0, 0.6, 0.8}, torch::kDouble);
  for (double angle : {1e-6, 0.3, 2.9}) {
    const Tensor to = -matrix_to_quaternion(axis_angle_to_matrix(axis * angle));  // the far side of the double cover
    for (double u : {0.0, 0.25, 0.5, 1.0}) {
      const Tensor q = slerp(from, to, torch::tensor(u, torch::kDouble));
      EXPECT_LT(largest(matrix_to_axis_angle(quaternion_to_matrix(q)) - axis * angle * u), 1e-9) << angle << " " << u;
    }
  }
  const Tensor many = slerp(from.expand({5, 4}), from.expand({5, 4}), torch::linspace(0, 1, 5, torch::kDouble));
  EXPECT_EQ(many.sizes(), torch::IntArrayRef({5, 4}));
}

TEST(Rotation, EigenAndTensorRotationsAgree) {
  const Tensor v = random_axis_angles(50, 3.1);
  const Tensor r = axis_angle_to_matrix(v);
  for (int64_t i = 0; i < v.size(0); ++i) {
    const Eigen::Vector3d x(v[i][0].item<double>(), v[i][1].item<double>(), v[i][2].item<double>());
    const Eigen::Quaterniond q = quaternion_of(x);
    EXPECT_LT((axis_angle_of(q) - x).norm(), 1e-10);
    const Eigen::Matrix3d m = q.toRotationMatrix();
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) EXPECT_NEAR(m(a, b), r[i][a][b].item<double>(), 1e-12);
  }
}

TEST(Rotation, FramesAreCarriedOver) {
  const Eigen::Quaterniond q = rotation_between_frames({0, -1, 0}, {0, 0, 1}, {1, 0, 0}, {0.5, 1, 0});
  EXPECT_LT((q * Eigen::Vector3d(0, -2, 0) - Eigen::Vector3d(2, 0, 0)).norm(), 1e-12);
  EXPECT_LT((q * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(0, 1, 0)).norm(), 1e-12);
}

}  // namespace
}  // namespace inhabit
