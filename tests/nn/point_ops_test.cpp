// Each operator against the plainest loop that says what it means.
#include "inhabit/nn/point_ops.h"
#include "largest.h"

#include <gtest/gtest.h>
#include <torch/csrc/autograd/autograd.h>

#include <algorithm>
#include <cmath>

using namespace inhabit;
using torch::Tensor;

namespace {

double squared_distance(const Tensor& points, int64_t b, int64_t i, const Tensor& others, int64_t j) {
  return (points[b][i] - others[b][j]).to(torch::kFloat64).square().sum().item<double>();
}

/// Gradient of sum(f(x) weights) by central differences, in double.
template <class F>
Tensor numeric_gradient(const F& f, const Tensor& x, const Tensor& weights) {
  torch::NoGradGuard no_gradients;
  const double step = 1e-5;
  Tensor gradient = torch::zeros_like(x);
  Tensor at = x.clone();
  auto flat = at.view(-1);
  for (int64_t i = 0; i < at.numel(); ++i) {
    const double value = flat[i].item<double>();
    flat[i] = value + step;
    const double above = (f(at) * weights).sum().template item<double>();
    flat[i] = value - step;
    const double below = (f(at) * weights).sum().template item<double>();
    flat[i] = value;
    gradient.view(-1)[i] = (above - below) / (2 * step);
  }
  return gradient;
}

nn::SparseMap random_map(int64_t batch, int64_t inputs, int64_t outputs, int64_t terms) {
  return {torch::randint(inputs, {batch, outputs, terms}, torch::kInt64), torch::rand({batch, outputs, terms}), inputs};
}

}  // namespace

TEST(SparseMap, GatherAndScatterAreTheMatrixAndItsTranspose) {
  torch::manual_seed(0);
  const nn::SparseMap map = random_map(2, 7, 5, 3);
  const Tensor x = torch::randn({2, 4, 7}), y = torch::randn({2, 4, 5});
  for (int64_t b = 0; b < 2; ++b) {
    Tensor matrix = torch::zeros({5, 7});
    for (int64_t i = 0; i < 5; ++i) {
      for (int64_t k = 0; k < 3; ++k) matrix[i][map.index[b][i][k].item<int64_t>()] += map.weight[b][i][k];
    }
    EXPECT_LT(largest_difference(nn::gather(map, x)[b], x[b].matmul(matrix.t())), 1e-5);
    EXPECT_LT(largest_difference(nn::scatter(map, y)[b], y[b].matmul(matrix)), 1e-5);
  }
}

TEST(SparseMap, WithoutWeightsEveryTermCountsOnce) {
  const nn::SparseMap map{torch::tensor({{{2}, {0}, {2}}}, torch::kInt64), {}, 3};
  EXPECT_TRUE(
      torch::equal(nn::gather(map, torch::tensor({{{1.0F, 2.0F, 3.0F}}})), torch::tensor({{{3.0F, 1.0F, 3.0F}}})));
  EXPECT_TRUE(
      torch::equal(nn::scatter(map, torch::tensor({{{1.0F, 2.0F, 4.0F}}})), torch::tensor({{{2.0F, 0.0F, 5.0F}}})));
}

TEST(SparseMap, GradientsAgreeWithFiniteDifferences) {
  torch::manual_seed(1);
  nn::SparseMap map = random_map(2, 6, 8, 3);
  const Tensor x = torch::randn({2, 3, 6}, torch::kFloat64).requires_grad_(true);
  const Tensor y = torch::randn({2, 3, 8}, torch::kFloat64).requires_grad_(true);
  const Tensor wx = torch::randn({2, 3, 8}, torch::kFloat64), wy = torch::randn({2, 3, 6}, torch::kFloat64);
  for (const bool weighted : {true, false}) {
    if (!weighted) map.weight = Tensor();
    const auto gather = [&](const Tensor& v) { return nn::gather(map, v); };
    const auto scatter = [&](const Tensor& v) { return nn::scatter(map, v); };
    EXPECT_LT(largest_difference(torch::autograd::grad({(gather(x) * wx).sum()}, {x})[0],
                                 numeric_gradient(gather, x.detach(), wx)),
              1e-7);
    EXPECT_LT(largest_difference(torch::autograd::grad({(scatter(y) * wy).sum()}, {y})[0],
                                 numeric_gradient(scatter, y.detach(), wy)),
              1e-7);
  }
}

TEST(Voxels, CoordinatesFillTheGridAndOnePlaceLandsInItsMiddle) {
  torch::manual_seed(2);
  const Tensor points = torch::randn({2, 50, 3});
  const Tensor at = nn::voxel_coordinates(points, 16);
  EXPECT_GE(at.min().item<float>(), 0);
  EXPECT_LE(at.max().item<float>(), 15);
  const Tensor centred = points[0] - points[0].mean(0);
  const double scale = 2 * centred.norm(2, 1).max().item<double>();
  EXPECT_LT(largest_difference(at[0], ((centred / scale + 0.5) * 16).clamp(0, 15)), 1e-5);
  EXPECT_TRUE(torch::equal(nn::voxel_coordinates(torch::full({1, 4, 3}, 1.5F), 8), torch::full({1, 4, 3}, 4.0F)));
}

TEST(Voxels, AverageIsTheMeanOfEachVoxelsPoints) {
  torch::manual_seed(3);
  const int64_t grid = 4, count = 40;
  const Tensor at = torch::rand({1, count, 3}) * 3;
  const Tensor x = torch::randn({1, 2, count});
  Tensor sum = torch::zeros({2, grid * grid * grid}), points = torch::zeros({grid * grid * grid});
  for (int64_t n = 0; n < count; ++n) {
    int64_t voxel = 0;
    for (int axis = 0; axis < 3; ++axis)
      voxel = voxel * grid + static_cast<int64_t>(std::nearbyint(at[0][n][axis].item<float>()));
    sum.select(1, voxel) += x[0].select(1, n);
    points[voxel] += 1;
  }
  EXPECT_LT(largest_difference(nn::scatter(nn::voxel_average(at, grid), x)[0], sum / points.clamp_min(1)), 1e-6);
}

TEST(Voxels, InterpolationReproducesAnAffineField) {
  torch::manual_seed(4);
  const int64_t grid = 5;
  Tensor at = torch::rand({1, 30, 3}) * (grid - 1);
  at[0][0] = torch::tensor({4.0F, 4.0F, 4.0F});  // on the grid's last corner
  at[0][1] = torch::tensor({0.0F, 2.0F, 4.0F});
  const Tensor axis = torch::arange(grid, torch::kFloat32);
  const Tensor field = axis.view({-1, 1, 1}) * 2 - axis.view({1, -1, 1}) + axis.view({1, 1, -1}) * 0.5 + 3;
  const Tensor expected = at[0].matmul(torch::tensor({2.0F, -1.0F, 0.5F})) + 3;
  const Tensor got = nn::gather(nn::voxel_interpolation(at, grid), field.reshape({1, 1, -1}));
  EXPECT_LT(largest_difference(got[0][0], expected), 1e-5);
}

TEST(FurthestPoints, FollowTheGreedyRule) {
  torch::manual_seed(5);
  for (const int64_t count : {1, 7, 33, 100}) {
    const Tensor points = torch::randn({1, count, 3});
    const int64_t wanted = std::min<int64_t>(count, 12);
    const Tensor got = nn::furthest_points(points, wanted);
    std::vector<double> distance(count, 1e30);
    int64_t last = 0;
    for (int64_t k = 0; k < wanted; ++k) {
      ASSERT_EQ(got[0][k].item<int64_t>(), last) << count << " points, choice " << k;
      for (int64_t n = 0; n < count; ++n)
        distance[n] = std::min(distance[n], squared_distance(points, 0, n, points, last));
      last = std::max_element(distance.begin(), distance.end()) - distance.begin();
    }
  }
}

TEST(FurthestPoints, MorePointsThanThereAreRepeatTheFirst) {
  EXPECT_TRUE(torch::equal(nn::furthest_points(torch::ones({1, 3, 3}), 5), torch::zeros({1, 5}, torch::kInt64)));
}

TEST(BallNeighbours, AreTheFirstInOrderAndRepeatTheFirstFound) {
  torch::manual_seed(6);
  const int64_t count = 70, wanted = 6;
  const Tensor points = torch::randn({2, count, 3}), centres = torch::randn({2, 9, 3});
  const Tensor got = nn::ball_neighbours(points, centres, 0.8, wanted);
  int partly = 0, none = 0;
  for (int64_t b = 0; b < 2; ++b) {
    for (int64_t m = 0; m < 9; ++m) {
      std::vector<int64_t> expected;
      for (int64_t n = 0; n < count && static_cast<int64_t>(expected.size()) < wanted; ++n) {
        if (squared_distance(points, b, n, centres, m) < 0.64) expected.push_back(n);
      }
      none += expected.empty() ? 1 : 0;
      partly += !expected.empty() && static_cast<int64_t>(expected.size()) < wanted ? 1 : 0;
      expected.resize(wanted, expected.empty() ? 0 : expected[0]);
      for (int64_t k = 0; k < wanted; ++k) EXPECT_EQ(got[b][m][k].item<int64_t>(), expected[k]);
    }
  }
  EXPECT_GT(partly, 0);
  EXPECT_GT(none, 0);
}

TEST(NearestInterpolation, WeighsTheThreeNearestByInverseSquaredDistance) {
  torch::manual_seed(7);
  const Tensor points = torch::randn({1, 20, 3}), centres = torch::randn({1, 37, 3});
  const nn::SparseMap map = nn::nearest_interpolation(points, centres);
  for (int64_t n = 0; n < 20; ++n) {
    std::vector<std::pair<double, int64_t>> order;
    for (int64_t m = 0; m < 37; ++m) order.emplace_back(squared_distance(points, 0, n, centres, m), m);
    std::sort(order.begin(), order.end());
    double total = 0;
    for (int k = 0; k < 3; ++k) total += 1 / order[k].first;
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(map.index[0][n][k].item<int64_t>(), order[k].second);
      EXPECT_NEAR(map.weight[0][n][k].item<double>(), 1 / order[k].first / total, 1e-4);
    }
  }
}

TEST(NearestInterpolation, ACentreGivesItsOwnValueAndFewCentresSuffice) {
  const Tensor centres = torch::tensor({{{0.0F, 0.0F, 0.0F}, {1.0F, 0.0F, 0.0F}}});
  const nn::SparseMap map = nn::nearest_interpolation(centres, centres);
  const Tensor got = nn::gather(map, torch::tensor({{{5.0F, 9.0F}}}));
  EXPECT_LT(largest_difference(got, torch::tensor({{{5.0F, 9.0F}}})), 1e-5);
}
