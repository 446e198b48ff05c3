// Protects the functions that kernels compute on vectors of numbers, against those of the standard library.
#include "inhabit/nn/vector_exp.h"

#include <gtest/gtest.h>

#include <cmath>

namespace inhabit::nn {
namespace {

typedef float Four __attribute__((vector_size(16)));

/// The largest that `of` is off from `exact` between -limit and limit, relative to the larger of 1 and what is exact.
template <class Of, class Exact>
double most_off(float limit, const Of& of, const Exact& exact) {
  double most = 0;
  for (int i = -2000; i < 2000; i += 4) {
    Four x;
    for (int k = 0; k < 4; ++k) x[k] = limit * static_cast<float>(i + k) / 2000;
    Four y = x;
    of(y);
    for (int k = 0; k < 4; ++k) {
      const double expected = exact(static_cast<double>(x[k]));
      most = std::max(most, std::abs(static_cast<double>(y[k]) - expected) / std::max(1.0, expected));
    }
  }
  return most;
}

TEST(VectorExp, IsExpWithinWhatAFloatHolds) {
  EXPECT_LT(most_off(
                80, [](Four& x) { vector_exp<4>(x); }, [](double x) { return std::exp(x); }),
            3e-7);
  Four far = {-500, 500, -88, 88};
  vector_exp<4>(far);
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(far[k] / std::exp(k % 2 == 0 ? -87.0 : 87.0), 1, 1e-5) << "clamped";
}

TEST(VectorSigmoid, IsTheSigmoid) {
  const auto of = [](Four& x) { vector_sigmoid<4>(x); };
  for (const float limit : {1.F, 30.F, 500.F})
    EXPECT_LT(most_off(limit, of, [](double x) { return 1 / (1 + std::exp(-x)); }), 2e-7) << limit;
}

TEST(VectorTanh, IsTanh) {
  const auto of = [](Four& x) { vector_tanh<4>(x); };
  for (const float limit : {1.F, 30.F, 500.F})
    EXPECT_LT(most_off(limit, of, [](double x) { return std::tanh(x); }), 4e-7) << limit;
}

}  // namespace
}  // namespace inhabit::nn
