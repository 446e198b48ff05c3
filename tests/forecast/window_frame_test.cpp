// Protects the axes that the networks see a window in: whatever way a person goes in the world, the window is the same.
#include "inhabit/forecast/window_frame.h"

#include <gtest/gtest.h>

#include "forecast/walker.h"
#include "inhabit/math/rotation.h"
#include "largest.h"

namespace inhabit::forecast {
namespace {

TEST(WindowFrame, ThePersonStandsAtTheOriginAndFacesPlusZ) {
  const Config config = preset("compact");
  for (const double yaw : {0.0, 0.7, 1.6, 3.1, -2.2}) {
    const torch::Tensor past = walker(config.past, 1.2, yaw, 1, 3, -2).joints;
    const torch::Tensor window = window_frame(past, config).to_window(past);
    EXPECT_LT(largest(window[config.past - 1][config.root]), 1e-6) << yaw;
    const torch::Tensor hips = window[config.past - 1][config.hips[0]] - window[config.past - 1][config.hips[1]];
    EXPECT_GT(hips[0].item<float>(), 0.05F) << yaw;  // left is +X
    EXPECT_LT(largest(hips[2]), 1e-5) << yaw;
    EXPECT_LT(window[0][config.root][2].item<float>(), -1.0F) << yaw;  // came from behind
  }
}

TEST(WindowFrame, GoesThereAndBack) {
  const Config config = preset("compact");
  const torch::Tensor past = walker(config.past, 0.8, 2.4, 1, -1, 4).joints, points = torch::randn({50, 3});
  const WindowFrame frame = window_frame(past, config);
  EXPECT_LT(largest(frame.to_world(frame.to_window(points)) - points), 1e-5);
  // Rigid; cdist of float32 keeps three digits of what is near.
  EXPECT_LT(largest(torch::cdist(frame.to_window(points), frame.to_window(points)) - torch::cdist(points, points)),
            5e-3);
  EXPECT_LT(largest(frame.to_window(points).select(1, 1) + frame.origin[1] - points.select(1, 1)), 1e-5);
}

TEST(WindowFrame, AClipTurnedByAnyYawGivesTheSameWindow) {
  const Config config = preset("compact");
  const torch::Tensor past = walker(config.past, 1.1, 0.4, 1, 0.5, 0.5).joints, points = torch::randn({50, 3});
  const WindowFrame frame = window_frame(past, config);
  for (const double yaw : {0.3, 1.5707963, 2.9, -1.1, 3.1415926}) {
    const torch::Tensor rotation = yaw_matrix(yaw).t(), shift = torch::tensor({2.F, 0.3F, -4.F});
    const torch::Tensor moved = torch::matmul(past, rotation) + shift;
    const WindowFrame there = window_frame(moved, config);
    EXPECT_LT(largest(there.to_window(moved) - frame.to_window(past)), 1e-5) << yaw;
    EXPECT_LT(largest(there.to_window(torch::matmul(points, rotation) + shift) - frame.to_window(points)), 1e-5) << yaw;
  }
}

TEST(WindowFrame, KeepsTheWorldsAxesWhereTheModelDoes) {
  const Config config = preset("paper");
  ASSERT_TRUE(config.hips.empty());
  const torch::Tensor past = walker(config.past, 1.2, 0.7, 1).joints;
  const WindowFrame frame = window_frame(past, config);
  EXPECT_TRUE(torch::equal(frame.rotation, torch::eye(3)));
  EXPECT_LT(largest(frame.to_window(past) - (past - past[config.past - 1][config.root])), 1e-6);
}

}  // namespace
}  // namespace inhabit::forecast
