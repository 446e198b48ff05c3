#pragma once
#include <torch/types.h>

#include <gtest/gtest.h>

#include "inhabit/math/simd.h"
#include "largest.h"

/// Runs `result`, which gives a tensor, at every level that the processor has, and expects that of the baseline, within
/// `tolerance` of the largest number (0: the same bits).
template <class Result>
void expect_same_at_all_levels(const Result& result, double tolerance, const std::string& what) {
  using namespace inhabit;
  const Simd before = simd_level();
  use_simd_level(Simd::kBaseline);
  const torch::Tensor expected = result().clone();
  for (const Simd level : {Simd::kAvx2, Simd::kAvx512}) {
    if (level > best_simd_level()) continue;
    use_simd_level(level);
    const torch::Tensor got = result();
    const double scale = std::max(1.0, largest(expected.to(torch::kFloat64)));
    EXPECT_LE(largest((got - expected).to(torch::kFloat64)), tolerance * scale)
        << what << " at " << simd_level_name(level);
  }
  use_simd_level(before);
}
