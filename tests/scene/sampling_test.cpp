#include "inhabit/scene/sampling.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "inhabit/error.h"
#include "inhabit/math/furthest_points.h"
#include "refusal_of.h"

namespace inhabit {
namespace {

TEST(Sampling, FloorIsCoveredEvenly) {
  const Scene floor = floor_scene(2.0);
  std::mt19937_64 random(1);
  const torch::Tensor points = sample_points(floor, 40000, random);
  EXPECT_EQ(points.select(1, 1).abs().max().item<float>(), 0.F);
  EXPECT_LE(points.abs().max().item<float>(), 1.F);
  const torch::Tensor cell =
      ((points.select(1, 0) + 1) * 2).floor().clamp(0, 3) * 4 + ((points.select(1, 2) + 1) * 2).floor().clamp(0, 3);
  const torch::Tensor counts = torch::bincount(cell.to(torch::kInt64), {}, 16).to(torch::kFloat32);
  // 2500 a cell; five standard deviations of a binomial are about 240.
  EXPECT_LT((counts - 2500).abs().max().item<float>(), 240);
}

TEST(Sampling, SameSeedSamePoints) {
  std::mt19937_64 a(7), b(7), c(8);
  const torch::Tensor first = sample_points(floor_scene(), 100, a);
  EXPECT_TRUE(torch::equal(first, sample_points(floor_scene(), 100, b)));
  EXPECT_FALSE(torch::equal(first, sample_points(floor_scene(), 100, c)));
}

TEST(Sampling, NearAPersonOnAHugeFloor) {
  const torch::Tensor center = torch::tensor({1.F, 0.9F, -2.F});
  for (const double size : {12.0, 50000.0}) {
    std::mt19937_64 random(1);
    const torch::Tensor points = sample_points_near(floor_scene(size), center, 2.5, 5000, random);
    ASSERT_EQ(points.size(0), 5000);
    EXPECT_LE((points - center).norm(2, 1).max().item<float>(), 2.5F + 1e-4F);
    // Evenly over the disc where the sphere meets the floor: the mean of r^2 is half its largest.
    const torch::Tensor r2 = (points - center).square().sum(1) - 0.81;
    EXPECT_NEAR(r2.mean().item<double>() / (2.5 * 2.5 - 0.81), 0.5, 0.02) << size;
    EXPECT_NEAR((points.select(1, 0) - 1).mean().item<double>(), 0, 0.08);
  }
}

TEST(Sampling, GrazingSurfaceAndFarScene) {
  std::mt19937_64 random(1);
  const torch::Tensor points = sample_points_near(floor_scene(), torch::tensor({0.F, 2.4999F, 0.F}), 2.5, 200, random);
  EXPECT_LE(points.norm(2, 1).max().item<float>(), 0.03F);
  EXPECT_THAT(refusal_of([&] {
                return sample_points_near(floor_scene(), torch::tensor({0.F, 10.F, 0.F}), 2.5, 200, random);
              }),
              testing::HasSubstr("nearest is 10.00 m away"));
  EXPECT_THROW(sample_points(Scene(), 10, random), Error);
  EXPECT_THROW(sample_points_near(Scene(), torch::zeros({3}), 1, 10, random), Error);
  EXPECT_THROW(sample_points_near(floor_scene(), torch::full({3}, NAN), 1, 10, random), Error);
}

TEST(Sampling, CloudsGiveDistinctPointsWhileTheyLast) {
  Scene cloud;
  cloud.points = torch::stack({torch::arange(100).to(torch::kFloat32), torch::zeros(100), torch::zeros(100)}, 1);
  std::mt19937_64 random(1);
  const auto distinct = [](const torch::Tensor& points) {
    return std::get<0>(torch::_unique2(points.select(1, 0))).numel();
  };
  EXPECT_EQ(distinct(sample_points(cloud, 60, random)), 60);
  EXPECT_EQ(distinct(sample_points(cloud, 250, random)), 100);
  const torch::Tensor near = sample_points_near(cloud, torch::tensor({50.F, 0.F, 0.F}), 10.5, 50, random);
  EXPECT_EQ(distinct(near), 21);
  EXPECT_GE(near.select(1, 0).min().item<float>(), 40);
  EXPECT_LE(near.select(1, 0).max().item<float>(), 60);
  EXPECT_THROW(sample_points_near(cloud, torch::tensor({-50.F, 0.F, 0.F}), 10, 50, random), Error);
}

TEST(Sampling, FurthestPointsOfALine) {
  const torch::Tensor line = torch::stack({torch::arange(9).to(torch::kFloat32), torch::zeros(9), torch::zeros(9)}, 1);
  EXPECT_TRUE(torch::equal(furthest_point_indices(line, 5), torch::tensor({0, 8, 4, 2, 6}, torch::kInt64)));
  EXPECT_THROW(furthest_point_indices(line, 10), Error);
}

}  // namespace
}  // namespace inhabit
