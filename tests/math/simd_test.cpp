// Protects the choice of vector instructions: names that can be told, and one line for those that cannot.
#include "inhabit/math/simd.h"

#include <gmock/gmock.h>

#include "refusal_of.h"

namespace inhabit {
namespace {

using ::testing::HasSubstr;

TEST(Simd, LevelsGoByNameAndNoneIsTakenThatTheProcessorLacks) {
  const Simd best = best_simd_level();
  for (const Simd level : {Simd::kBaseline, Simd::kAvx2, Simd::kAvx512}) {
    const std::string name = simd_level_name(level);
    if (level <= best) {
      EXPECT_EQ(simd_level_named(name, "x"), level);
      continue;
    }
    EXPECT_EQ(refusal_of([&] { simd_level_named(name, "x"); }), "x: this processor has no " + name);
    EXPECT_THAT(refusal_of([&] { use_simd_level(level); }), HasSubstr(name));
  }
  EXPECT_THAT(refusal_of([] { simd_level_named("avx9", "INHABIT_SIMD"); }),
              HasSubstr("INHABIT_SIMD: 'avx9' is none of"));
}

TEST(Simd, ALevelThatIsSetIsTheOneInUse) {
  const Simd before = simd_level();
  use_simd_level(Simd::kBaseline);
  EXPECT_EQ(simd_level(), Simd::kBaseline);
  use_simd_level(before);
  EXPECT_EQ(simd_level(), before);
}

}  // namespace
}  // namespace inhabit
