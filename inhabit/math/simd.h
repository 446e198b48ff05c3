#pragma once

namespace inhabit {

/// What vector instructions the processor that runs us has. Kernels (files named *_kernel.cpp) are compiled for each
/// and chosen at run time, so that one binary serves every x86-64; elsewhere the baseline is used.
enum class Simd { kBaseline, kAvx2, kAvx512 };

inline Simd simd_level() {
#if defined(__x86_64__)
  static const Simd level = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                                    __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw")
                                ? Simd::kAvx512
                            : __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? Simd::kAvx2
                                                                                              : Simd::kBaseline;
  return level;
#else
  return Simd::kBaseline;
#endif
}

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
