#include "inhabit/math/simd.h"

#include <atomic>
#include <cstdlib>

#include "inhabit/error.h"

namespace inhabit {
namespace {

constexpr const char* kVariable = "INHABIT_SIMD";

std::atomic<Simd>& level_in_use() {
  static std::atomic<Simd> level = [] {
    const char* named = std::getenv(kVariable);
    return named == nullptr || *named == '\0' ? best_simd_level() : simd_level_named(named, kVariable);
  }();
  return level;
}

}  // namespace

Simd best_simd_level() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512bw"))
    return Simd::kAvx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return Simd::kAvx2;
#endif
  return Simd::kBaseline;
}

const char* simd_level_name(Simd level) {
  return level == Simd::kAvx512 ? "avx512" : level == Simd::kAvx2 ? "avx2" : "baseline";
}

Simd simd_level_named(const std::string& name, const std::string& subject) {
  for (const Simd level : {Simd::kBaseline, Simd::kAvx2, Simd::kAvx512}) {
    if (name != simd_level_name(level)) continue;
    if (level > best_simd_level()) throw Error(subject, "this processor has no " + name);
    return level;
  }
  throw Error(subject, "'" + name.substr(0, 30) + "' is none of baseline, avx2, avx512");
}

Simd simd_level() { return level_in_use().load(std::memory_order_relaxed); }

void use_simd_level(Simd level) {
  if (level > best_simd_level()) throw Error(std::string("this processor has no ") + simd_level_name(level));
  level_in_use() = level;
}

}  // namespace inhabit
