// Protects the floor that is told from poses alone: from feet that are slow, from key poses, and from heights.
#include "inhabit/motion/floor.h"

#include <gtest/gtest.h>

namespace inhabit {
namespace {

/// Two balls of the feet at these heights, (T, 2) metres, which stand still on the ground plane; 30 frames a second.
Clip feet_at(const torch::Tensor& heights) {
  Clip clip;
  clip.skeleton.names = {"pelvis", "left_foot", "right_foot"};
  clip.skeleton.parents = {-1, 0, 0};
  clip.skeleton.offsets = torch::zeros({3, 3});
  clip.rate = 30;
  clip.joints = torch::zeros({heights.size(0), 3, 3});
  clip.joints.select(1, 0).select(1, 1).fill_(1);
  clip.joints.slice(1, 1, 3).select(2, 1).copy_(heights);
  return clip;
}

TEST(FloorUnderPoses, IsTwoCentimetresUnderTheBallsOfSlowFeet) {
  torch::Tensor heights = torch::full({90, 2}, 0.52);
  heights.slice(0, 40, 45).select(1, 0) = torch::tensor({0.6, 0.3, 0.8, 0.4, 0.6});  // kicks, below the floor too
  EXPECT_NEAR(floor_under(feet_at(heights)), 0.5, 1e-6);
  EXPECT_NEAR(floor_under(feet_at(heights.slice(0, 38, 50))), 0.28, 1e-6) << "of key poses the lowest tells";
}

TEST(FloorUnderLowest, LeavesATwentiethOfTheFramesBelow) {
  std::vector<double> heights;
  for (int i = 0; i < 100; ++i) heights.push_back(0.01 * ((37 * i) % 100));  // 0 to 99 cm, in any order
  EXPECT_NEAR(floor_under_lowest(heights), 0.05 - 0.02, 1e-12);
  EXPECT_NEAR(floor_under_lowest({0.7, 0.3, 0.5}), 0.3 - 0.02, 1e-12) << "of few frames the lowest tells";
  // Of feet that stand it is what floor_under() says.
  EXPECT_NEAR(floor_under_lowest(std::vector<double>(90, 0.52)), floor_under(feet_at(torch::full({90, 2}, 0.52))),
              1e-6);
}

}  // namespace
}  // namespace inhabit
