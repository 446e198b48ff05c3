#pragma once

#include <string>

namespace inhabit {

/// What vector instructions kernels use. Kernels (files named *_kernel.cpp) are compiled for each level and chosen at
/// run time, so that one binary serves every x86-64; elsewhere the baseline is used.
enum class Simd { kBaseline, kAvx2, kAvx512 };

/// The level in use: the highest that the processor has, unless the environment's INHABIT_SIMD says baseline, avx2 or
/// avx512. Throws Error("INHABIT_SIMD", ...) where it says anything else or what the processor lacks.
Simd simd_level();

/// The highest that the processor has.
Simd best_simd_level();

/// The copy of a kernel for the level in use.
template <class Kernel>
Kernel* for_simd_level(Kernel* avx512, Kernel* avx2, Kernel* baseline) {
  const Simd level = simd_level();
  return level == Simd::kAvx512 ? avx512 : level == Simd::kAvx2 ? avx2 : baseline;
}

/// From now on, in every thread: for tests, which compare the levels. Throws Error where the processor lacks it.
void use_simd_level(Simd level);

const char* simd_level_name(Simd level);
/// Throws Error(subject, ...) for other names and for what the processor lacks.
Simd simd_level_named(const std::string& name, const std::string& subject);

#if defined(__x86_64__)
#define INHABIT_TARGET_AVX2 __attribute__((target("avx2,fma")))
#if defined(__clang__)  // knows no preferred width, and one unknown word makes it ignore the rest
#define INHABIT_TARGET_AVX512 __attribute__((target("avx512f,avx512dq,avx512vl,avx512bw,avx2,fma")))
#else
#define INHABIT_TARGET_AVX512 \
  __attribute__((target("avx512f,avx512dq,avx512vl,avx512bw,avx2,fma,prefer-vector-width=512")))
#endif
#else
#define INHABIT_TARGET_AVX2
#define INHABIT_TARGET_AVX512
#endif
#define INHABIT_INLINE inline __attribute__((always_inline))

}  // namespace inhabit
