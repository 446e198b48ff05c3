#include "inhabit/body/skin_kernel.h"

#include <cstring>

#include "inhabit/math/simd.h"

namespace inhabit {
namespace {

constexpr int kNumbers = sizeof(SkinTransform) / sizeof(float);

/// The blend of a vertex's transforms is held in vectors of kWidth floats. Products and sums are rounded one by one and
/// in one order (no fused multiply-add: CMakeLists.txt), so that every width gives the same bits.
template <int kWidth>
INHABIT_INLINE void skin_of(const SparseWeights& weights, const SkinTransform* transforms, const float* rest,
                            float* skinned) {
  typedef float Float __attribute__((vector_size(kWidth * sizeof(float)), aligned(4), may_alias));
  typedef float Column __attribute__((vector_size(4 * sizeof(float)), aligned(4), may_alias));
  constexpr int kParts = kNumbers / kWidth;
  const auto vertices = static_cast<int64_t>(weights.first.size()) - 1;
  const int32_t *first = weights.first.data(), *joint = weights.joint.data();
  const float* weight = weights.weight.data();
  for (int64_t v = 0; v < vertices; ++v, rest += 3, skinned += 3) {
    Float blend[kParts] = {};
    for (int32_t k = first[v]; k < first[v + 1]; ++k) {
      const float* transform = &transforms[joint[k]].columns[0][0];
#pragma GCC unroll 4
      for (int p = 0; p < kParts; ++p) blend[p] += weight[k] * reinterpret_cast<const Float&>(transform[p * kWidth]);
    }
    Column column[4];
    std::memcpy(column, blend, sizeof(SkinTransform));
    const Column point = column[0] * rest[0] + column[1] * rest[1] + column[2] * rest[2] + column[3];
    // Four floats at once: the next vertex writes over the fourth, which behind the last one is somebody else's.
    if (v + 1 < vertices)
      std::memcpy(skinned, &point, sizeof(point));
    else
      std::memcpy(skinned, &point, 3 * sizeof(float));
  }
}

INHABIT_TARGET_AVX512 void skin_avx512(const SparseWeights& weights, const SkinTransform* transforms, const float* rest,
                                       float* skinned) {
  skin_of<16>(weights, transforms, rest, skinned);
}
INHABIT_TARGET_AVX2 void skin_avx2(const SparseWeights& weights, const SkinTransform* transforms, const float* rest,
                                   float* skinned) {
  skin_of<8>(weights, transforms, rest, skinned);
}

}  // namespace

void skin_vertices(const SparseWeights& weights, const SkinTransform* transforms, const float* rest, float* skinned) {
  for_simd_level(skin_avx512, skin_avx2, skin_of<4>)(weights, transforms, rest, skinned);
}

}  // namespace inhabit
