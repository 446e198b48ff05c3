// Protects the passes of a group norm and its activation against tensor operators, with widths that fill no vector.
#include "inhabit/nn/norm_kernel.h"
#include "largest.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

namespace inhabit::nn {
namespace {

using torch::Tensor;

TEST(NormKernel, SumsColumns) {
  torch::manual_seed(1);
  for (const int64_t columns : {1, 12, 16, 53}) {
    const Tensor x = torch::randn({37, 60}) + 3;
    Tensor sums = torch::full({columns + 1}, -1.F);
    column_sums(x.data_ptr<float>(), 60, 37, columns, 0, false, sums.data_ptr<float>());
    EXPECT_LT(largest(sums.slice(0, 0, columns) - x.slice(1, 0, columns).sum(0)), 1e-4);
    column_sums(x.data_ptr<float>(), 60, 37, columns, 2.5F, true, sums.data_ptr<float>());
    EXPECT_LT(largest(sums.slice(0, 0, columns) - (x.slice(1, 0, columns) - 2.5F).square().sum(0)), 1e-4);
    EXPECT_EQ(sums[columns].item<float>(), -1) << "nothing is written behind the last";
  }
}

TEST(NormKernel, ScalesShiftsAndActivates) {
  torch::manual_seed(2);
  for (const int64_t columns : {1, 12, 16, 53}) {
    const Tensor x = torch::randn({9, 60}) * 10, scale = torch::randn({columns}), shift = torch::randn({columns}),
                 add = torch::randn({9, 70});
    for (const bool adds : {false, true}) {
      Tensor y = torch::zeros({9, 64});
      scaled_mish(x.data_ptr<float>(), 60, 9, columns, scale.data_ptr<float>(), shift.data_ptr<float>(),
                  adds ? add.data_ptr<float>() : nullptr, 70, y.data_ptr<float>(), 64);
      Tensor expected = torch::mish(x.slice(1, 0, columns) * scale + shift);
      if (adds) expected = expected + add.slice(1, 0, columns);
      EXPECT_LT(largest(y.slice(1, 0, columns) - expected), 1e-5);
      EXPECT_EQ(largest(y.slice(1, columns)), 0) << "nothing is written behind the last";
    }
  }
}

TEST(NormKernel, MishHoldsAtItsEnds) {
  const Tensor x = torch::tensor(
      {-1e6F, -200.F, -88.F, -30.F, -1e-6F, 0.F, 1e-6F, 15.F, 19.9F, 20.1F, 88.F, 200.F, 1e30F, -5.F, 5.F, 1.F, -1.F});
  const Tensor one = torch::ones_like(x), zero = torch::zeros_like(x);
  Tensor y = torch::empty_like(x);
  scaled_mish(x.data_ptr<float>(), 0, 1, x.numel(), one.data_ptr<float>(), zero.data_ptr<float>(), nullptr, 0,
              y.data_ptr<float>(), 0);
  const Tensor exact = torch::mish(x.to(torch::kFloat64).clamp_min(-700));
  EXPECT_TRUE(y.isfinite().all().item<bool>());
  EXPECT_LT(largest((y.to(torch::kFloat64) - exact) / exact.abs().clamp_min(1e-6)), 1e-6);
}

}  // namespace
}  // namespace inhabit::nn
