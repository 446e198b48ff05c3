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

TEST(FuturesError, IsOverTheJointsButTheRootAndTheBestIsOneFuture) {
  torch::Tensor truth = torch::zeros({4, 22, 3}), futures = torch::zeros({3, 4, 22, 3});
  futures[0].slice(1, 1, 22).select(2, 0).fill_(0.1);                // all of 21 joints by 10 cm
  futures[1].slice(0, 0, 2).slice(1, 1, 2).select(2, 1).fill_(2.1);  // one by 2.1 m in half of the frames
  futures[2].slice(1, 1, 22).select(2, 2).fill_(-0.3);
  const FuturesError error = futures_error(futures, truth);
  EXPECT_TRUE(torch::allclose(error.each[0], torch::full({4}, 0.1F)));
  EXPECT_TRUE(torch::allclose(error.best, torch::tensor({0.1F, 0.1F, 0.F, 0.F}))) << "0.05 in the mean over time";
}

}  // namespace
}  // namespace inhabit
