#include "inhabit/forecast/contact_kernel.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "inhabit/math/simd.h"

namespace inhabit::forecast {
namespace {

constexpr int64_t kBlock = 64;  // points handled together

/// exp(x) for x in [-87, 0], within 2 units in the last place: 2^n times a polynomial on [-ln 2 / 2, ln 2 / 2].
INHABIT_INLINE float exp_of_negative(float x) {
  const float shifted = x * 1.44269504F + 12582912.0F;  // adding 1.5 2^23 rounds to the nearest integer
  const float n = shifted - 12582912.0F;
  const float r = (x - n * 0.693359375F) + n * 2.12194440e-4F;
  float p = 1.9875691500e-4F;
  p = p * r + 1.3981999507e-3F;
  p = p * r + 8.3334519073e-3F;
  p = p * r + 4.1665795894e-2F;
  p = p * r + 1.6666665459e-1F;
  p = p * r + 5.0000001201e-1F;
  p = p * r * r + r + 1.0F;
  const auto exponent = static_cast<int32_t>(n);
  int32_t bits = (exponent + 127) << 23;
  float power;
  std::memcpy(&power, &bits, sizeof power);
  return p * power;
}

INHABIT_INLINE void coefficients_kernel(const float* const points[3], int64_t count, const float* joint, int64_t frames,
                                        const float* basis, int64_t coefficients, float sigma, float* out,
                                        int64_t stride) {
  // A ball around the joint's path, and the points near enough to it.
  float low[3], high[3];
  for (int a = 0; a < 3; ++a) low[a] = high[a] = joint[a];
  for (int64_t f = 1; f < frames; ++f) {
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], joint[3 * f + a]);
      high[a] = std::max(high[a], joint[3 * f + a]);
    }
  }
  float centre[3], half = 0;
  for (int a = 0; a < 3; ++a) {
    centre[a] = 0.5F * (low[a] + high[a]);
    half += (high[a] - low[a]) * (high[a] - low[a]) * 0.25F;
  }
  const float reach = std::sqrt(half) + 5.77F * sigma;
  std::vector<int32_t> near;
  near.reserve(static_cast<size_t>(count));
  for (int64_t n = 0; n < count; ++n) {
    const float x = points[0][n] - centre[0], y = points[1][n] - centre[1], z = points[2][n] - centre[2];
    if (x * x + y * y + z * z < reach * reach) near.push_back(static_cast<int32_t>(n));
  }
  for (int64_t l = 0; l < coefficients; ++l) std::fill_n(out + l * stride, count, 0.0F);

  const float scale = -0.5F / (sigma * sigma);
  std::vector<float> contact(static_cast<size_t>(frames * kBlock));
  float x[kBlock], y[kBlock], z[kBlock], sum[kBlock];
  for (size_t first = 0; first < near.size(); first += kBlock) {
    const int64_t got = std::min<int64_t>(kBlock, static_cast<int64_t>(near.size() - first));
    for (int64_t i = 0; i < kBlock; ++i) {
      const int32_t n = near[first + static_cast<size_t>(std::min(i, got - 1))];
      x[i] = points[0][n];
      y[i] = points[1][n];
      z[i] = points[2][n];
    }
    for (int64_t f = 0; f < frames; ++f) {
      const float jx = joint[3 * f], jy = joint[3 * f + 1], jz = joint[3 * f + 2];
      float* row = contact.data() + f * kBlock;
      for (int64_t i = 0; i < kBlock; ++i) {
        const float dx = x[i] - jx, dy = y[i] - jy, dz = z[i] - jz;
        const float power = std::max(scale * (dx * dx + dy * dy + dz * dz), -87.0F);
        row[i] = exp_of_negative(power);
      }
    }
    for (int64_t l = 0; l < coefficients; ++l) {
      std::fill_n(sum, kBlock, 0.0F);
      const float* weights = basis + l * frames;
      for (int64_t f = 0; f < frames; ++f) {
        const float w = weights[f];
        const float* row = contact.data() + f * kBlock;
        for (int64_t i = 0; i < kBlock; ++i) sum[i] += w * row[i];
      }
      float* target = out + l * stride;
      for (int64_t i = 0; i < got; ++i) target[near[first + static_cast<size_t>(i)]] = sum[i];
    }
  }
}

/// Points of which any frame's value may be over `least`: no value is over the lengths of the point's coefficients and
/// of the frame's row of the basis, multiplied (Cauchy and Schwarz).
INHABIT_INLINE void points_over(const float* c, int64_t stride, int64_t count, const float* basis, int64_t coefficients,
                                int64_t frames, float least, std::vector<int32_t>& found) {
  float longest = 0;  // squared, of the basis' rows
  for (int64_t t = 0; t < frames; ++t) {
    float square = 0;
    for (int64_t l = 0; l < coefficients; ++l) square += basis[t * coefficients + l] * basis[t * coefficients + l];
    longest = std::max(longest, square);
  }
  const float bound = least > 0 ? 0.999F * least * least : -1.0F;
  float square[kBlock];
  for (int64_t first = 0; first < count; first += kBlock) {
    const int64_t got = std::min(kBlock, count - first);
    std::fill_n(square, kBlock, 0.0F);
    for (int64_t l = 0; l < coefficients; ++l) {
      const float* row = c + l * stride + first;
      for (int64_t i = 0; i < got; ++i) square[i] += row[i] * row[i];
    }
    for (int64_t i = 0; i < got; ++i)
      if (square[i] * longest > bound) found.push_back(static_cast<int32_t>(first + i));
  }
}

INHABIT_INLINE void largest_kernel(const float* c, int64_t stride, int64_t count, const float* basis,
                                   int64_t coefficients, int64_t frames, float least, float* value, int64_t* index) {
  std::fill_n(value, frames, -std::numeric_limits<float>::infinity());
  std::fill_n(index, frames, int64_t{0});
  std::vector<int32_t> points;
  points.reserve(static_cast<size_t>(count));
  points_over(c, stride, count, basis, coefficients, frames, least, points);
  std::vector<float> block(static_cast<size_t>(coefficients * kBlock));
  float sum[kBlock];
  for (size_t first = 0; first < points.size(); first += kBlock) {
    const int64_t got = std::min<int64_t>(kBlock, static_cast<int64_t>(points.size() - first));
    for (int64_t l = 0; l < coefficients; ++l) {
      for (int64_t i = 0; i < kBlock; ++i)
        block[l * kBlock + i] = c[l * stride + points[first + static_cast<size_t>(std::min(i, got - 1))]];
    }
    for (int64_t t = 0; t < frames; ++t) {
      std::fill_n(sum, kBlock, 0.0F);
      for (int64_t l = 0; l < coefficients; ++l) {
        const float w = basis[t * coefficients + l];
        const float* row = block.data() + l * kBlock;
        for (int64_t i = 0; i < kBlock; ++i) sum[i] += w * row[i];
      }
      float best = sum[0];
      for (int64_t i = 1; i < kBlock; ++i) best = sum[i] > best ? sum[i] : best;
      if (!(best > value[t])) continue;
      for (int64_t i = 0; i < got; ++i) {
        if (sum[i] == best) {
          value[t] = best;
          index[t] = points[first + static_cast<size_t>(i)];
          break;
        }
      }
    }
  }
}

INHABIT_INLINE void closest_kernel(const float* const points[3], int64_t count, const float* joint, int64_t frames,
                                   float* squared_distance, int64_t* index) {
  float distance[kBlock];
  for (int64_t f = 0; f < frames; ++f) {
    const float jx = joint[3 * f], jy = joint[3 * f + 1], jz = joint[3 * f + 2];
    float least = std::numeric_limits<float>::infinity();
    int64_t at = 0;
    for (int64_t first = 0; first < count; first += kBlock) {
      const int64_t got = std::min(kBlock, count - first);
      float best = std::numeric_limits<float>::infinity();
      for (int64_t i = 0; i < got; ++i) {
        const float x = points[0][first + i] - jx, y = points[1][first + i] - jy, z = points[2][first + i] - jz;
        distance[i] = x * x + y * y + z * z;
      }
      for (int64_t i = 0; i < got; ++i) best = distance[i] < best ? distance[i] : best;
      if (!(best < least)) continue;
      for (int64_t i = 0; i < got; ++i) {
        if (distance[i] == best) {
          least = best;
          at = first + i;
          break;
        }
      }
    }
    squared_distance[f] = least;
    index[f] = at;
  }
}

// One copy per instruction set.
INHABIT_TARGET_AVX512 void coefficients_avx512(const float* const p[3], int64_t n, const float* j, int64_t f,
                                               const float* b, int64_t l, float s, float* o, int64_t stride) {
  coefficients_kernel(p, n, j, f, b, l, s, o, stride);
}
INHABIT_TARGET_AVX2 void coefficients_avx2(const float* const p[3], int64_t n, const float* j, int64_t f,
                                           const float* b, int64_t l, float s, float* o, int64_t stride) {
  coefficients_kernel(p, n, j, f, b, l, s, o, stride);
}
INHABIT_TARGET_AVX512 void largest_avx512(const float* c, int64_t s, int64_t n, const float* b, int64_t l, int64_t f,
                                          float least, float* v, int64_t* i) {
  largest_kernel(c, s, n, b, l, f, least, v, i);
}
INHABIT_TARGET_AVX2 void largest_avx2(const float* c, int64_t s, int64_t n, const float* b, int64_t l, int64_t f,
                                      float least, float* v, int64_t* i) {
  largest_kernel(c, s, n, b, l, f, least, v, i);
}
INHABIT_TARGET_AVX512 void closest_avx512(const float* const p[3], int64_t n, const float* j, int64_t f, float* d,
                                          int64_t* i) {
  closest_kernel(p, n, j, f, d, i);
}
INHABIT_TARGET_AVX2 void closest_avx2(const float* const p[3], int64_t n, const float* j, int64_t f, float* d,
                                      int64_t* i) {
  closest_kernel(p, n, j, f, d, i);
}

}  // namespace

void contact_coefficients_of_joint(const float* const points[3], int64_t count, const float* joint, int64_t frames,
                                   const float* basis, int64_t coefficients, float sigma, float* out, int64_t stride) {
  for_simd_level(coefficients_avx512, coefficients_avx2, coefficients_kernel)(points, count, joint, frames, basis,
                                                                              coefficients, sigma, out, stride);
}

void largest_contact_of_joint(const float* c, int64_t stride, int64_t count, const float* basis, int64_t coefficients,
                              int64_t frames, float least, float* value, int64_t* index) {
  for_simd_level(largest_avx512, largest_avx2, largest_kernel)(c, stride, count, basis, coefficients, frames, least,
                                                               value, index);
}

void closest_point_of_joint(const float* const points[3], int64_t count, const float* joint, int64_t frames,
                            float* squared_distance, int64_t* index) {
  for_simd_level(closest_avx512, closest_avx2, closest_kernel)(points, count, joint, frames, squared_distance, index);
}

}  // namespace inhabit::forecast
