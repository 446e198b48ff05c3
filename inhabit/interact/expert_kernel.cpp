#include "inhabit/interact/expert_kernel.h"

#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>

#include "inhabit/math/simd.h"
#include "inhabit/nn/vector_exp.h"

namespace inhabit::interact {
namespace {

constexpr int64_t kDepth = 128;  // inputs that share scales: 16 KB of weights, which stay in the first-level cache

/// Bytes of one expert's block of columns: for every 128 inputs a scale for each column, then the weights.
int64_t block_bytes(int64_t in) {
  return (in + kDepth - 1) / kDepth * kExpertColumns * int64_t{sizeof(float)} + in * kExpertColumns * 2;
}

/// Vectors of whole numbers: spelt out for each width, because GCC 12 converts none whose width is a parameter's.
template <int kWidth>
struct Whole;
template <>
struct Whole<4> {
  typedef int16_t Short __attribute__((vector_size(8)));
  typedef int32_t Int __attribute__((vector_size(16)));
  typedef float Float __attribute__((vector_size(16)));
};
template <>
struct Whole<8> {
  typedef int16_t Short __attribute__((vector_size(16)));
  typedef int32_t Int __attribute__((vector_size(32)));
  typedef float Float __attribute__((vector_size(32)));
};
template <>
struct Whole<16> {
  typedef int16_t Short __attribute__((vector_size(32)));
  typedef int32_t Int __attribute__((vector_size(64)));
  typedef float Float __attribute__((vector_size(64)));
};

/// Sums of `kRows` rows over `depth` inputs for kVectors vectors of columns, times scale and gate, added to y.
template <int kWidth, int kVectors, int kRows>
INHABIT_INLINE void tile(const int16_t* w, const float* scale, int64_t depth, const float* x, int64_t x_stride,
                         const float* gate, float* y) {
  typedef float vec __attribute__((vector_size(kWidth * sizeof(float)), aligned(4), may_alias));
  using Short = typename Whole<kWidth>::Short;
  using Int = typename Whole<kWidth>::Int;
  using Float = typename Whole<kWidth>::Float;
  vec sum[kRows][kVectors];
#pragma GCC unroll 8
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 8
    for (int v = 0; v < kVectors; ++v) sum[r][v] = vec{};
  }
  for (int64_t c = 0; c < depth; ++c, w += kExpertColumns) {
    vec weight[kVectors];
#pragma GCC unroll 8
    for (int v = 0; v < kVectors; ++v) {
      Short number;
      std::memcpy(&number, w + v * kWidth, sizeof(number));
      weight[v] = __builtin_convertvector(__builtin_convertvector(number, Int), Float);
    }
#pragma GCC unroll 8
    for (int r = 0; r < kRows; ++r) {
      const float value = x[r * x_stride + c];
#pragma GCC unroll 8
      for (int v = 0; v < kVectors; ++v) sum[r][v] += value * weight[v];
    }
  }
#pragma GCC unroll 8
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 8
    for (int v = 0; v < kVectors; ++v) {
      vec& to = *reinterpret_cast<vec*>(y + r * kExpertColumns + v * kWidth);
      to += gate[r] * *reinterpret_cast<const vec*>(scale + v * kWidth) * sum[r][v];
    }
  }
}

template <int kWidth, int kVectors, int kRows>
INHABIT_INLINE void tiles_across(const uint8_t* at, int64_t depth, const float* x, int64_t x_stride, const float* gate,
                                 float* y) {
  const auto* scale = reinterpret_cast<const float*>(at);
  const auto* w = reinterpret_cast<const int16_t*>(at + kExpertColumns * sizeof(float));
  for (int64_t column = 0; column < kExpertColumns; column += kWidth * kVectors)
    tile<kWidth, kVectors, kRows>(w + column, scale + column, depth, x, x_stride, gate, y + column);
}

template <int kWidth>
INHABIT_INLINE void activate(Activation activation, float* y, int64_t count) {
  typedef float vec __attribute__((vector_size(kWidth * sizeof(float)), aligned(4), may_alias));
  if (activation == Activation::kNone) return;
  for (int64_t i = 0; i < count; i += kWidth) {
    vec& value = *reinterpret_cast<vec*>(y + i);
    vec low = value;
    if (activation == Activation::kElu) {
      nn::vector_exp<kWidth>(low);
      low = low - 1.0F;
    } else {
      low = kLeak * low;
    }
    value = value > 0.0F ? value : low;
  }
}

/// @param kWide, kTall vectors of a tile of one row, and of one of several.
template <int kWidth, int kWide, int kTall>
INHABIT_INLINE void products(const PackedExperts& w, int64_t block, const float* x, int64_t x_stride,
                             const float* gates, int64_t gate_stride, int64_t rows, Activation activation, float* y,
                             int64_t y_stride) {
  constexpr int kRows = 6;
  alignas(64) float sums[kExpertRows * kExpertColumns];
  float gate[kExpertRows];
  std::fill_n(sums, rows * kExpertColumns, 0.0F);
  const uint8_t* at = w.data.get() + block * w.experts * block_bytes(w.in);
  for (int64_t e = 0; e < w.experts; ++e) {
    float most = 0;
    const float* bias = w.bias.data() + (e * w.blocks() + block) * kExpertColumns;
    for (int64_t r = 0; r < rows; ++r) {
      gate[r] = gates != nullptr ? gates[r * gate_stride + e] : 1.0F;
      most = std::max(most, gate[r]);
      for (int64_t c = 0; c < kExpertColumns; ++c) sums[r * kExpertColumns + c] += gate[r] * bias[c];
    }
    if (most < kNoGate) {
      at += block_bytes(w.in);
      continue;
    }
    for (int64_t first = 0; first < w.in; first += kDepth) {
      const int64_t depth = std::min(kDepth, w.in - first);
      int64_t r = 0;
      for (; r + kRows <= rows; r += kRows)
        tiles_across<kWidth, kTall, kRows>(at, depth, x + r * x_stride + first, x_stride, gate + r,
                                           sums + r * kExpertColumns);
      if (r + 3 <= rows) {
        tiles_across<kWidth, kTall, 3>(at, depth, x + r * x_stride + first, x_stride, gate + r,
                                       sums + r * kExpertColumns);
        r += 3;
      }
      for (; r < rows; ++r)
        tiles_across<kWidth, kWide, 1>(at, depth, x + r * x_stride + first, x_stride, gate + r,
                                       sums + r * kExpertColumns);
      at += kExpertColumns * (int64_t{sizeof(float)} + 2 * depth);
    }
  }
  activate<kWidth>(activation, sums, rows * kExpertColumns);
  const int64_t columns = std::min(kExpertColumns, w.out - block * kExpertColumns);
  for (int64_t r = 0; r < rows; ++r) std::copy_n(sums + r * kExpertColumns, columns, y + r * y_stride);
}

/// x becomes 1 / (1 + exp(-x)).
template <int kWidth, class Float>
INHABIT_INLINE void sigmoid_of(Float& x) {
  x = -x;
  nn::vector_exp<kWidth>(x);
  x = 1.0F / (1.0F + x);
}
/// x becomes tanh(x) = 2 sigmoid(2 x) - 1.
template <int kWidth, class Float>
INHABIT_INLINE void tanh_of(Float& x) {
  x = 2.0F * x;
  sigmoid_of<kWidth>(x);
  x = 2.0F * x - 1.0F;
}

template <int kWidth>
INHABIT_INLINE void units(const float* gates, float* cell, float* hidden) {
  typedef float vec __attribute__((vector_size(kWidth * sizeof(float)), aligned(4), may_alias));
  for (int i = 0; i < 16; i += kWidth) {
    const auto gate = [&](int which) { return gates + 16 * which + i; };
    vec in = *reinterpret_cast<const vec*>(gate(0)), keep = *reinterpret_cast<const vec*>(gate(1)),
        candidate = *reinterpret_cast<const vec*>(gate(2)), out = *reinterpret_cast<const vec*>(gate(3));
    sigmoid_of<kWidth>(in);
    sigmoid_of<kWidth>(keep);
    tanh_of<kWidth>(candidate);
    sigmoid_of<kWidth>(out);
    vec& c = *reinterpret_cast<vec*>(cell + i);
    c = keep * c + in * candidate;
    vec shown = c;
    tanh_of<kWidth>(shown);
    *reinterpret_cast<vec*>(hidden + i) = out * shown;
  }
}

// One copy per instruction set.
INHABIT_TARGET_AVX512 void products_avx512(const PackedExperts& w, int64_t block, const float* x, int64_t x_stride,
                                           const float* gates, int64_t gate_stride, int64_t rows, Activation activation,
                                           float* y, int64_t y_stride) {
  products<16, 4, 4>(w, block, x, x_stride, gates, gate_stride, rows, activation, y, y_stride);
}
INHABIT_TARGET_AVX2 void products_avx2(const PackedExperts& w, int64_t block, const float* x, int64_t x_stride,
                                       const float* gates, int64_t gate_stride, int64_t rows, Activation activation,
                                       float* y, int64_t y_stride) {
  products<8, 8, 2>(w, block, x, x_stride, gates, gate_stride, rows, activation, y, y_stride);
}
INHABIT_TARGET_AVX512 void units_avx512(const float* gates, float* cell, float* hidden) {
  units<16>(gates, cell, hidden);
}
INHABIT_TARGET_AVX2 void units_avx2(const float* gates, float* cell, float* hidden) { units<8>(gates, cell, hidden); }

/// Zeros on large pages where the system has them: a frame reads all weights, once.
std::shared_ptr<uint8_t> large_pages(size_t bytes) {
  constexpr size_t kPage = size_t{1} << 21;
  const size_t rounded = (bytes + kPage - 1) / kPage * kPage;
  // Of little there would be more rounding than weights.
  void* memory = std::aligned_alloc(bytes < kPage ? 64 : kPage, bytes < kPage ? (bytes + 63) / 64 * 64 : rounded);
  if (memory == nullptr) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
  if (bytes >= kPage) madvise(memory, rounded, MADV_HUGEPAGE);
#endif
  std::memset(memory, 0, bytes);
  return {static_cast<uint8_t*>(memory), [](uint8_t* p) { std::free(p); }};
}

}  // namespace

PackedExperts pack_experts(const float* weight, const float* bias, int64_t experts, int64_t out, int64_t in) {
  PackedExperts w;
  w.experts = experts;
  w.in = in;
  w.out = out;
  const int64_t blocks = w.blocks();
  const std::shared_ptr<uint8_t> data = large_pages(static_cast<size_t>(blocks * experts * block_bytes(in)));
  w.bias.assign(static_cast<size_t>(experts * blocks * kExpertColumns), 0.0F);
  uint8_t* at = data.get();
  for (int64_t block = 0; block < blocks; ++block) {
    const int64_t begin = block * kExpertColumns, columns = std::min(kExpertColumns, out - begin);
    for (int64_t e = 0; e < experts; ++e) {
      std::copy_n(bias + e * out + begin, columns, w.bias.data() + (e * blocks + block) * kExpertColumns);
      for (int64_t first = 0; first < in; first += kDepth) {
        const int64_t depth = std::min(kDepth, in - first);
        auto* scales = reinterpret_cast<float*>(at);
        auto* numbers = reinterpret_cast<int16_t*>(at + kExpertColumns * sizeof(float));
        for (int64_t c = 0; c < columns; ++c) {
          const float* column = weight + (e * out + begin + c) * in + first;
          float most = 0;
          for (int64_t i = 0; i < depth; ++i) most = std::max(most, std::abs(column[i]));
          scales[c] = most / 32767;
          for (int64_t i = 0; i < depth && scales[c] > 0; ++i)
            numbers[i * kExpertColumns + c] =
                static_cast<int16_t>(std::clamp(std::round(column[i] / scales[c]), -32767.0F, 32767.0F));
        }
        at += kExpertColumns * (int64_t{sizeof(float)} + 2 * depth);
      }
    }
  }
  w.data = data;
  return w;
}

void expert_products(const PackedExperts& w, int64_t block, const float* x, int64_t x_stride, const float* gates,
                     int64_t gate_stride, int64_t rows, Activation activation, float* y, int64_t y_stride) {
  switch (simd_level()) {
    case Simd::kAvx512:
      return products_avx512(w, block, x, x_stride, gates, gate_stride, rows, activation, y, y_stride);
    case Simd::kAvx2:
      return products_avx2(w, block, x, x_stride, gates, gate_stride, rows, activation, y, y_stride);
    case Simd::kBaseline:
      return products<4, 8, 2>(w, block, x, x_stride, gates, gate_stride, rows, activation, y, y_stride);
  }
}

void lstm_units(const float* gates, float* cell, float* hidden) {
  switch (simd_level()) {
    case Simd::kAvx512:
      return units_avx512(gates, cell, hidden);
    case Simd::kAvx2:
      return units_avx2(gates, cell, hidden);
    case Simd::kBaseline:
      return units<4>(gates, cell, hidden);
  }
}

}  // namespace inhabit::interact
