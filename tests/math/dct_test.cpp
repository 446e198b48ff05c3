#include "inhabit/math/dct.h"

#include <gtest/gtest.h>

#include "inhabit/error.h"

using namespace inhabit;

TEST(Dct, IsOrthonormalAndItsTransposeInvertsIt) {
  const torch::Tensor dct = dct_matrix(90, 90), idct = idct_matrix(90, 90);
  EXPECT_LT((dct.matmul(idct) - torch::eye(90)).abs().max().item<float>(), 2e-6);
  EXPECT_LT((idct.matmul(dct) - torch::eye(90)).abs().max().item<float>(), 2e-6);
}

TEST(Dct, MatchesEquationThreeByHand) {
  // P = 2: h1 = sqrt(2/2) (c1 + c2)/sqrt 2, h2 = c1 cos(pi/4) + c2 cos(3 pi/4).
  const torch::Tensor h = dct_matrix(2, 2).matmul(torch::tensor({3.0F, 1.0F}));
  EXPECT_NEAR(h[0].item<float>(), 4 / std::sqrt(2.0), 1e-6);
  EXPECT_NEAR(h[1].item<float>(), 2 / std::sqrt(2.0), 1e-6);
}

TEST(Dct, ACosineHasOneCoefficientAndAConstantOnlyTheFirst) {
  const int64_t n = 24;
  const torch::Tensor dct = dct_matrix(n, n);
  const torch::Tensor cosine = torch::cos((torch::arange(n) + 0.5) * (M_PI * 5.0 / n));
  torch::Tensor expected = torch::zeros(n);
  expected[5] = std::sqrt(n / 2.0);
  EXPECT_LT((dct.matmul(cosine) - expected).abs().max().item<float>(), 1e-5);
  torch::Tensor constant = torch::zeros(n);
  constant[0] = std::sqrt(static_cast<float>(n));
  EXPECT_LT((dct.matmul(torch::ones(n)) - constant).abs().max().item<float>(), 1e-5);
}

TEST(Dct, FirstCoefficientsKeepSmoothSequences) {
  const torch::Tensor smooth = torch::exp(-(torch::arange(90) - 40.0).pow(2) / 400.0);
  const torch::Tensor back = idct_matrix(90, 20).matmul(dct_matrix(90, 20).matmul(smooth));
  EXPECT_LT((back - smooth).abs().max().item<float>(), 2e-3);
}

TEST(Dct, PaddedMatrixEqualsPaddingTheSequence) {
  torch::manual_seed(1);
  const torch::Tensor past = torch::randn({30, 7});
  const torch::Tensor padded = torch::cat({past, past.slice(0, 29).expand({60, 7})});
  const torch::Tensor expected = dct_matrix(90, 20).matmul(padded);
  EXPECT_LT((padded_dct_matrix(30, 60, 20).matmul(past) - expected).abs().max().item<float>(), 1e-5);
}

TEST(Dct, RefusesImpossibleSizes) {
  EXPECT_THROW(dct_matrix(10, 11), Error);
  EXPECT_THROW(dct_matrix(0, 0), Error);
  EXPECT_THROW(padded_dct_matrix(0, 5, 1), Error);
}
