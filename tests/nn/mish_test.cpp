// Protects mish and its gradient against tensor operators: every vector width's remainder, large and small inputs,
// rows that do not lie one behind the other, and half-precision input.
#include "inhabit/nn/mish.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

namespace inhabit {
namespace {

using torch::Tensor;

TEST(Mish, IsThatOfTensorOperatorsWithItsGradient) {
  torch::manual_seed(1);
  for (const int64_t count : {1, 7, 16, 53, 40000}) {
    const Tensor x = (torch::randn({count}) * 12).requires_grad_(), g = torch::randn({count});
    const Tensor exact = x.detach().to(torch::kFloat64).requires_grad_();
    const Tensor y = nn::mish(x), expected = torch::mish(exact);
    EXPECT_TRUE(torch::allclose(y.to(torch::kFloat64), expected, 1e-5, 1e-6)) << count;
    const Tensor slope = torch::autograd::grad({y}, {x}, {g})[0],
                 expected_slope = torch::autograd::grad({expected}, {exact}, {g.to(torch::kFloat64)})[0];
    EXPECT_TRUE(torch::allclose(slope.to(torch::kFloat64), expected_slope, 1e-5, 1e-6)) << count;
  }
}

TEST(Mish, StaysFiniteAtTheEnds) {
  const Tensor x = torch::tensor({-1e30F, -100.F, -20.F, 0.F, 20.F, 100.F, 1e30F}).requires_grad_();
  const Tensor y = nn::mish(x), slope = torch::autograd::grad({y.sum()}, {x})[0];
  EXPECT_TRUE(slope.isfinite().all().item<bool>()) << slope;
  EXPECT_EQ(y[5].item<float>(), 100);
  EXPECT_NEAR(y[1].item<float>(), 0, 1e-6);
  EXPECT_NEAR(slope[6].item<float>(), 1, 1e-6);
}

TEST(Mish, TakesAnyLayoutAndPrecision) {
  torch::manual_seed(2);
  const Tensor x = torch::randn({6, 5, 4});
  const Tensor turned = nn::mish(x.transpose(0, 2));
  EXPECT_TRUE(torch::allclose(turned, torch::mish(x).transpose(0, 2), 1e-5, 1e-6));
  const Tensor coarse = nn::mish(x.to(torch::kBFloat16));
  EXPECT_EQ(coarse.scalar_type(), torch::kFloat32);
  EXPECT_TRUE(torch::allclose(coarse, turned.transpose(0, 2), 0.02, 0.02));
}

}  // namespace
}  // namespace inhabit
