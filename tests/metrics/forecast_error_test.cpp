// Protects the definitions of path and pose error against hand-computed cases.
#include "inhabit/metrics/forecast_error.h"

#include <gtest/gtest.h>

namespace inhabit {
namespace {

TEST(ForecastError, AShiftedBodyHasPathErrorOnly) {
  torch::manual_seed(1);
  const torch::Tensor truth = torch::randn({2, 3, 5, 3});
  const torch::Tensor moved = truth + torch::tensor({3.F, 0.F, 4.F});
  EXPECT_TRUE(torch::allclose(path_error(moved, truth, 1), torch::full({2, 3}, 5.F), 1e-5, 1e-5));
  EXPECT_TRUE(torch::allclose(pose_error(moved, truth, 1), torch::zeros({2, 3}), 1e-5, 1e-5));
}

TEST(ForecastError, PoseErrorIsTheMeanOverTheOtherJoints) {
  torch::Tensor truth = torch::zeros({1, 1, 5, 3}), moved = truth.clone();
  moved[0][0][2][1] = 0.2F;  // one of the four joints that are not the root
  EXPECT_FLOAT_EQ(pose_error(moved, truth, 0).item<float>(), 0.05F);
  EXPECT_FLOAT_EQ(path_error(moved, truth, 0).item<float>(), 0.F);
}

}  // namespace
}  // namespace inhabit
