// Protects INHABIT_SIMD: every level forecasts the same, and what is no level is refused before anything is done.
#include "inhabit/math/simd.h"
#include "cli/command.h"
#include "cli/examples.h"
#include "cli/refusal.h"
#include "inhabit/io/clip_npz.h"
#include "largest.h"

namespace inhabit {
namespace {

TEST(SimdOfTheCommand, LevelsForecastTheSame) {
  const TempFolder folder;
  torch::Tensor baseline;
  for (const Simd level : {Simd::kBaseline, Simd::kAvx2, Simd::kAvx512}) {
    if (level > best_simd_level()) continue;
    const std::string name = simd_level_name(level), out = folder / (name + ".npz");
    const CommandResult r = run_program("INHABIT_SIMD=" + name + " " INHABIT_COMMAND " forecast " + kWalk +
                                        " --scene " + kRoom + " --start 30 -o " + out);
    ASSERT_EQ(r.exit_code, 0) << r.err;
    const torch::Tensor joints = read_clip_npz(out).joints;
    if (!baseline.defined()) baseline = joints;
    EXPECT_LT(largest(joints - baseline), 1e-3) << name;
  }
}

TEST(SimdOfTheCommand, WhatIsNoLevelIsRefusedInOneLine) {
  const CommandResult r = run_program("INHABIT_SIMD=sse9 " INHABIT_COMMAND " info " + kWalk);
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_EQ(r.err, "inhabit: INHABIT_SIMD: 'sse9' is none of baseline, avx2, avx512\n");
}

}  // namespace
}  // namespace inhabit
