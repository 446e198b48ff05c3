#include "inhabit/nn/point_kernel.h"

#include <cmath>
#include <cstring>
#include <limits>

#include "inhabit/math/simd.h"

namespace inhabit::nn {
namespace {

constexpr int64_t kLanes = 16;
constexpr float kFarAway = 1e17F;

typedef float Floats __attribute__((vector_size(kLanes * sizeof(float)), aligned(4), may_alias));
typedef int32_t Ints __attribute__((vector_size(kLanes * sizeof(int32_t)), aligned(4), may_alias));

INHABIT_INLINE const Floats& lanes(const float* p) { return *reinterpret_cast<const Floats*>(p); }

INHABIT_INLINE bool any(const Ints& mask) {
  typedef int64_t Longs __attribute__((vector_size(sizeof(Ints)), may_alias));
  const Longs& words = reinterpret_cast<const Longs&>(mask);
  int64_t all = 0;
  for (size_t i = 0; i < sizeof(Longs) / sizeof(int64_t); ++i) all |= words[i];
  return all != 0;
}

INHABIT_INLINE void furthest_kernel(const PointArrays& cloud, int64_t count, int64_t* chosen) {
  std::vector<float> distance(static_cast<size_t>(cloud.padded), -1.0F);
  std::fill(distance.begin(), distance.begin() + cloud.count, std::numeric_limits<float>::max());
  Ints step;
  for (int i = 0; i < kLanes; ++i) step[i] = i;
  int64_t last = 0;
  chosen[0] = 0;
  for (int64_t k = 1; k < count; ++k) {
    const float x = cloud.x[last], y = cloud.y[last], z = cloud.z[last];
    Floats best = Floats{} - 2.0F;
    Ints at = {}, index = step;
    for (int64_t n = 0; n < cloud.padded; n += kLanes, index += static_cast<int32_t>(kLanes)) {
      const Floats dx = lanes(&cloud.x[n]) - x, dy = lanes(&cloud.y[n]) - y, dz = lanes(&cloud.z[n]) - z;
      const Floats d = dx * dx + dy * dy + dz * dz;
      Floats& kept = reinterpret_cast<Floats&>(distance[n]);
      const Floats now = d < kept ? d : kept;
      kept = now;
      const Ints further = now > best;
      best = further ? now : best;
      at = further ? index : at;
    }
    float most = best[0];
    last = at[0];
    for (int i = 1; i < kLanes; ++i) {
      if (best[i] > most || (best[i] == most && at[i] < last)) {
        most = best[i];
        last = at[i];
      }
    }
    chosen[k] = last;
  }
}

INHABIT_INLINE int64_t ball_kernel(const PointArrays& cloud, const float* centre, float squared_radius, int64_t wanted,
                                   int64_t* found) {
  int64_t got = 0;
  for (int64_t n = 0; n < cloud.padded; n += kLanes) {
    const Floats dx = lanes(&cloud.x[n]) - centre[0], dy = lanes(&cloud.y[n]) - centre[1],
                 dz = lanes(&cloud.z[n]) - centre[2];
    const Ints inside = dx * dx + dy * dy + dz * dz < squared_radius;
    if (!any(inside)) continue;
    for (int i = 0; i < kLanes; ++i) {
      if (inside[i] == 0) continue;
      found[got++] = n + i;
      if (got == wanted) return got;
    }
  }
  return got;
}

INHABIT_INLINE void nearest_kernel(const PointArrays& cloud, const float* point, float best[3], int64_t at[3]) {
  for (int k = 0; k < 3; ++k) {
    best[k] = std::numeric_limits<float>::infinity();
    at[k] = 0;
  }
  for (int64_t n = 0; n < cloud.padded; n += kLanes) {
    const Floats dx = lanes(&cloud.x[n]) - point[0], dy = lanes(&cloud.y[n]) - point[1],
                 dz = lanes(&cloud.z[n]) - point[2];
    const Floats d = dx * dx + dy * dy + dz * dz;
    const Ints nearer = d < best[2];
    if (!any(nearer)) continue;
    const int64_t end = cloud.count - n < kLanes ? cloud.count - n : kLanes;
    for (int64_t i = 0; i < end; ++i) {
      if (!(d[i] < best[2])) continue;
      int slot = 2;
      for (; slot > 0 && d[i] < best[slot - 1]; --slot) {
        best[slot] = best[slot - 1];
        at[slot] = at[slot - 1];
      }
      best[slot] = d[i];
      at[slot] = n + i;
    }
  }
}

INHABIT_TARGET_AVX512 void furthest_avx512(const PointArrays& c, int64_t n, int64_t* out) {
  furthest_kernel(c, n, out);
}
INHABIT_TARGET_AVX2 void furthest_avx2(const PointArrays& c, int64_t n, int64_t* out) { furthest_kernel(c, n, out); }
INHABIT_TARGET_AVX512 int64_t ball_avx512(const PointArrays& c, const float* p, float r, int64_t n, int64_t* out) {
  return ball_kernel(c, p, r, n, out);
}
INHABIT_TARGET_AVX2 int64_t ball_avx2(const PointArrays& c, const float* p, float r, int64_t n, int64_t* out) {
  return ball_kernel(c, p, r, n, out);
}
INHABIT_TARGET_AVX512 void nearest_avx512(const PointArrays& c, const float* p, float* d, int64_t* i) {
  nearest_kernel(c, p, d, i);
}
INHABIT_TARGET_AVX2 void nearest_avx2(const PointArrays& c, const float* p, float* d, int64_t* i) {
  nearest_kernel(c, p, d, i);
}

}  // namespace

PointArrays::PointArrays(const float* points, int64_t n) : count(n), padded((n + kLanes - 1) / kLanes * kLanes) {
  for (auto* axis : {&x, &y, &z}) axis->assign(static_cast<size_t>(padded), kFarAway);
  for (int64_t i = 0; i < n; ++i) {
    x[i] = points[3 * i];
    y[i] = points[3 * i + 1];
    z[i] = points[3 * i + 2];
  }
}

void furthest_points_of_cloud(const PointArrays& cloud, int64_t count, int64_t* chosen) {
  for_simd_level(furthest_avx512, furthest_avx2, furthest_kernel)(cloud, count, chosen);
}

int64_t points_in_ball(const PointArrays& cloud, const float* centre, float squared_radius, int64_t wanted,
                       int64_t* found) {
  return for_simd_level(ball_avx512, ball_avx2, ball_kernel)(cloud, centre, squared_radius, wanted, found);
}

void three_nearest_points(const PointArrays& cloud, const float* point, float squared_distance[3], int64_t index[3]) {
  for_simd_level(nearest_avx512, nearest_avx2, nearest_kernel)(cloud, point, squared_distance, index);
}

}  // namespace inhabit::nn
