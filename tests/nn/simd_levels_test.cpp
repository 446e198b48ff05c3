// Protects the kernels' other copies: what a processor with narrower vectors computes is what this one does.
#include "simd_levels.h"

#include <torch/torch.h>

#include "inhabit/nn/gru_kernel.h"
#include "inhabit/nn/mish_kernel.h"
#include "inhabit/nn/norm_kernel.h"
#include "inhabit/nn/point_kernel.h"
#include "inhabit/nn/row_products_kernel.h"

namespace inhabit::nn {
namespace {

using torch::Tensor;

TEST(SimdLevels, PointwiseKernelsAgree) {
  torch::manual_seed(1);
  for (const int64_t count : {1, 7, 16, 53, 1000}) {
    const Tensor x = torch::randn({count}) * 8, g = torch::randn({count}), gates = torch::randn({6 * count});
    const auto name = std::to_string(count) + " numbers";
    const auto filled = [&](const auto& fill) {
      Tensor y = torch::zeros({count});
      fill(y.data_ptr<float>());
      return y;
    };
    expect_same_at_all_levels([&] { return filled([&](float* y) { mish_forward(x.data_ptr<float>(), count, y); }); },
                              1e-6, "mish, " + name);
    expect_same_at_all_levels(
        [&] { return filled([&](float* y) { mish_backward(x.data_ptr<float>(), g.data_ptr<float>(), count, y); }); },
        1e-6, "gradient of mish, " + name);
    expect_same_at_all_levels(
        [&] {
          const float* in = gates.data_ptr<float>();
          return filled([&](float* y) { gru_update(count, in, in + 3 * count, x.data_ptr<float>(), y); });
        },
        1e-6, "GRU, " + name);
  }
}

TEST(SimdLevels, NormsAgree) {
  torch::manual_seed(2);
  const Tensor x = torch::randn({9, 60}) * 3, scale = torch::randn({53}), shift = torch::randn({53});
  expect_same_at_all_levels(
      [&] {
        Tensor sums = torch::zeros({53});
        column_sums(x.data_ptr<float>(), 60, 9, 53, 0.5F, true, sums.data_ptr<float>());
        return sums;
      },
      1e-6, "sums of columns");
  expect_same_at_all_levels(
      [&] {
        Tensor y = torch::zeros({9, 60});
        scaled_mish(x.data_ptr<float>(), 60, 9, 53, scale.data_ptr<float>(), shift.data_ptr<float>(),
                    x.data_ptr<float>(), 60, y.data_ptr<float>(), 60);
        return y;
      },
      1e-6, "norm and mish");
}

TEST(SimdLevels, ProductsOfRowsAgree) {
  torch::manual_seed(3);
  for (const int64_t out : {5, 64, 150})
    for (const int64_t rows : {1, 6, 29}) {
      const Tensor w = torch::randn({37, out}), x = torch::randn({rows, 37});
      const PackedMatrix packed = pack_matrix(w.data_ptr<float>(), 37, out, out, 1);
      const auto product = [&] {
        Tensor y = torch::zeros({rows, packed.stride()});
        accumulate_rows(packed, 37, x.data_ptr<float>(), 37, nullptr, nullptr, rows, y.data_ptr<float>());
        return y;
      };
      expect_same_at_all_levels(product, 2e-6, std::to_string(rows) + " rows, " + std::to_string(out) + " columns");
      EXPECT_LT(largest(product().slice(1, 0, out) - x.mm(w)), 1e-4);
    }
}

TEST(SimdLevels, SearchesAmongPointsGiveTheSamePoints) {
  torch::manual_seed(4);
  for (const int64_t count : {1, 15, 16, 333}) {
    const Tensor points = torch::rand({count, 3}), at = torch::rand({3});
    const PointArrays cloud(points.data_ptr<float>(), count);
    const std::string name = std::to_string(count) + " points";
    const auto numbers = [](int64_t n) { return torch::zeros({n}, torch::kInt64); };
    expect_same_at_all_levels(
        [&] {
          Tensor chosen = numbers(std::min<int64_t>(count, 9));
          furthest_points_of_cloud(cloud, chosen.size(0), chosen.data_ptr<int64_t>());
          return chosen;
        },
        0, "furthest points, " + name);
    expect_same_at_all_levels(
        [&] {
          Tensor found = numbers(8);
          found[7] = points_in_ball(cloud, at.data_ptr<float>(), 0.2F, 7, found.data_ptr<int64_t>());
          return found;
        },
        0, "points in a ball, " + name);
    expect_same_at_all_levels(
        [&] {
          Tensor nearest = numbers(3);
          float squared[3];
          three_nearest_points(cloud, at.data_ptr<float>(), squared, nearest.data_ptr<int64_t>());
          return nearest.slice(0, 0, std::min<int64_t>(3, count));
        },
        0, "three nearest, " + name);
  }
}

}  // namespace
}  // namespace inhabit::nn
