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

TEST(FuturesError, OfOneFutureIsItsPoseError) {
  torch::manual_seed(2);
  torch::Tensor truth = torch::randn({5, 22, 3}), future = torch::randn({1, 5, 22, 3});
  truth.select(1, 0).zero_();
  future.select(2, 0).zero_();
  const FuturesError error = futures_error(future, truth);
  EXPECT_TRUE(torch::allclose(error.best, pose_error(future, truth.unsqueeze(0), 0)[0]));
  EXPECT_TRUE(torch::allclose(error.best, (future[0] - truth).norm(2, {2}).sum(1) / 21));
}

TEST(NearestFuture, IsOfJointsInTheWorldMeanOverFramesAndJoints) {
  torch::Tensor truth = torch::zeros({2, 4, 5, 3}), futures = torch::zeros({2, 3, 4, 5, 3});
  // First window: the whole body 10 cm off; the right path with one of five joints 40 cm off, 8 cm in the mean; nearly
  // right until it leaves by 1 m in the last frame.
  futures[0][0].select(2, 0).fill_(0.1);
  futures[0][1].select(1, 3).select(1, 1).fill_(-0.4);
  futures[0][2][3].select(1, 2).fill_(1);
  // Second window, elsewhere: the last one is as it was.
  truth[1].select(2, 0).fill_(5);
  futures[1][2].select(2, 0).fill_(5);
  EXPECT_EQ(nearest_future(futures, truth)[0].item<int64_t>(), 1);
  EXPECT_EQ(nearest_future(futures, truth)[1].item<int64_t>(), 2);
}

}  // namespace
}  // namespace inhabit
