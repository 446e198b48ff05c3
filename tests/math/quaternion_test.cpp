#include "inhabit/math/quaternion.h"

#include <gtest/gtest.h>

using namespace inhabit;
using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST(LogDerivative, IsThatOfDifferences) {
  for (const double angle : {0.0, 1e-4, 0.999e-3, 1.001e-3, 0.3, 1.5, 3.0}) {
    const Vector3d a = angle * Vector3d(1, -2, 2) / 3;
    const Matrix3d analytic = log_derivative(a);
    constexpr double kStep = 1e-5;  // radians
    for (int i = 0; i < 3; ++i) {
      const Vector3d d = kStep * Vector3d::Unit(i);
      const Vector3d change = axis_angle_of(quaternion_of(a) * quaternion_of(d)) -
                              axis_angle_of(quaternion_of(a) * quaternion_of(Vector3d(-d)));
      EXPECT_LT((change / (2 * kStep) - analytic.col(i)).norm(), 1e-7) << angle;
    }
  }
}

TEST(CrossMatrix, IsTheCrossProduct) {
  const Vector3d a(1, 2, 3), b(-2, 0.5, 1);
  EXPECT_LT((cross_matrix(a) * b - a.cross(b)).norm(), 1e-15);
}
