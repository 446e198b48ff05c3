// Protects the joint limits' one home: signed excess, component by component.
#include "inhabit/body/joint_limits.h"

#include <gtest/gtest.h>

namespace inhabit {
namespace {

TEST(JointLimits, SayWhatIsBeyond) {
  BodyModel body = builtin_body();
  body.joint_limits = body.joint_limits.clone();
  body.joint_limits[4][0][0] = -0.2;
  body.joint_limits[4][0][1] = 2.5;
  const JointLimits limits = joint_limits(body);
  EXPECT_EQ(limits.beyond(4, {1, 0, 0}), Eigen::Vector3d::Zero());
  EXPECT_NEAR(limits.beyond(4, {3, 0, 0}).x(), 0.5, 1e-6);
  EXPECT_NEAR(limits.beyond(4, {-1, 0, 0}).x(), -0.8, 1e-6);
  EXPECT_EQ(joint_limits(body, 5).high.size(), 5);
  EXPECT_EQ(joint_limits(body, 5).high.back(), limits.high[4]);
  body.joint_limits = torch::Tensor();
  EXPECT_EQ(joint_limits(body).beyond(4, {3.1, -3.1, 3.1}), Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace inhabit
