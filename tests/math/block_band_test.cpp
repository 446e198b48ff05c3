// Protects the block-banded factorisation that the trajectory solver and the fit of rotations stand on: against a dense
// solver at every level of vector instructions.
#include "inhabit/math/block_band.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>
#include <tuple>

#include "dense_band.h"
#include "inhabit/math/simd.h"

namespace inhabit {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// How far the band's solution of a random system is from that of a dense solver, as a part of it.
double distance_from_dense(int frames, int block, int band) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  BlockBand matrix(frames, block, band);
  for (int64_t t = 0; t < frames; ++t) {
    matrix.clear(t);
    for (int k = 0; k <= band && t + k < frames; ++k)
      matrix.at(t, k) = MatrixXd::NullaryExpr(block, block, [&] { return normal(random); });
    matrix.at(t, 0).diagonal().array() += 10.0 * block * (band + 1);
  }
  const MatrixXd whole = dense(matrix);
  const VectorXd right = VectorXd::NullaryExpr(int64_t{frames} * block, [&] { return normal(random); });
  VectorXd got = right;
  if (!matrix.solve([](int64_t) {}, got)) return INFINITY;
  return (got - whole.llt().solve(right)).norm() / got.norm();
}

TEST(BlockBand, SolvesAsADenseSolverDoesAtEveryLevelOfInstructions) {
  const Simd before = simd_level();
  for (const Simd level : {Simd::kBaseline, Simd::kAvx2, Simd::kAvx512}) {
    if (level > best_simd_level()) continue;
    use_simd_level(level);
    for (const auto& [frames, block, band] : {std::tuple(1, 4, 0),
                                              {3, 2, 3},
                                              {9, 5, 1},
                                              {40, 3, 3},
                                              {41, 7, 2},
                                              {24, 6, 3},
                                              {7, 1, 0},
                                              {18, 69, 2},
                                              {30, 54, 1},
                                              {12, 60, 2},
                                              {26, 66, 3}})
      EXPECT_LT(distance_from_dense(frames, block, band), 1e-9)
          << frames << " " << block << " " << band << " at " << simd_level_name(level);
  }
  use_simd_level(before);
}

TEST(BlockBand, SaysWhatHasNoFactor) {
  BlockBand matrix(30, 2, 1);
  for (const int64_t bad : {3, 14, 15, 17, 29}) {  // from either end, and where they meet
    const auto fill = [&](int64_t t) {
      matrix.clear(t);
      matrix.at(t, 0).setIdentity();
      if (t == bad) matrix.at(t, 0)(1, 1) = -1;
    };
    VectorXd x = VectorXd::Ones(60);
    EXPECT_FALSE(matrix.solve(fill, x)) << bad;
  }
}

}  // namespace
}  // namespace inhabit
