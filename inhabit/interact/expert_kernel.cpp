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

constexpr int64_t kDepth = 64;    // inputs that share scales; their weights stay in the first-level cache for all rows
constexpr int64_t kAhead = 1024;  // bytes: how far ahead of their use weights that are used once are asked for

/// Bytes of the weights of `depth` inputs with their scales, which stand before them for each column.
int64_t part_bytes(int64_t depth, bool floats) {
  return kExpertColumns * (int64_t{sizeof(float)} + depth * (floats ? 4 : 2));
}
/// Bytes of one expert's block of columns.
int64_t block_bytes(int64_t in, bool floats) {
  return in / kDepth * part_bytes(kDepth, floats) + (in % kDepth != 0 ? part_bytes(in % kDepth, floats) : 0);
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

template <int kWidth>
INHABIT_INLINE void load_weights(const int16_t* w, typename Whole<kWidth>::Float& to) {
  typename Whole<kWidth>::Short numbers;
  std::memcpy(&numbers, w, sizeof(numbers));
  to = __builtin_convertvector(__builtin_convertvector(numbers, typename Whole<kWidth>::Int),
                               typename Whole<kWidth>::Float);
}
template <int kWidth>
INHABIT_INLINE void load_weights(const float* w, typename Whole<kWidth>::Float& to) {
  std::memcpy(&to, w, sizeof(to));
}

/// Sums of `kRows` rows over `depth` inputs for kVectors vectors of columns, times scale and gate, added to y. Of
/// nn/row_products_kernel's tile it has the shape alone: here weights have 16 bits, their scales and the gates are
/// taken once behind the sum, and those of a single row are asked for ahead.
template <int kWidth, int kVectors, int kRows, class Weight>
INHABIT_INLINE void tile(const Weight* w, const float* scale, int64_t depth, const float* x, int64_t x_stride,
                         const float* gate, float* y) {
  typedef float vec __attribute__((vector_size(kWidth * sizeof(float)), aligned(4), may_alias));
  vec sum[kRows][kVectors];
#pragma GCC unroll 8
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 8
    for (int v = 0; v < kVectors; ++v) sum[r][v] = vec{};
  }
  for (int64_t c = 0; c < depth; ++c, w += kExpertColumns) {
    if constexpr (kRows == 1) {
      const char* ahead = reinterpret_cast<const char*>(w) + kAhead;
#pragma GCC unroll 8
      for (size_t b = 0; b < kVectors * kWidth * sizeof(Weight); b += 64) __builtin_prefetch(ahead + b, 0, 3);
    }
    typename Whole<kWidth>::Float weight[kVectors];
#pragma GCC unroll 8
    for (int v = 0; v < kVectors; ++v) load_weights<kWidth>(w + v * kWidth, weight[v]);
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

template <int kWidth, int kVectors, int kRows, class Weight>
INHABIT_INLINE void tiles_across(const uint8_t* at, int64_t depth, const float* x, int64_t x_stride, const float* gate,
                                 float* y) {
  const auto* scale = reinterpret_cast<const float*>(at);
  const auto* w = reinterpret_cast<const Weight*>(at + kExpertColumns * sizeof(float));
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
template <int kWidth, int kWide, int kTall, class Weight>
INHABIT_INLINE void products_of(const PackedExperts& w, int64_t block, const float* x, int64_t x_stride,
                                const float* gates, int64_t gate_stride, int64_t rows, Activation activation, float* y,
                                int64_t y_stride) {
  constexpr int kRows = 6;
  alignas(64) float sums[kExpertRows * kExpertColumns];
  float gate[kExpertRows];
  std::fill_n(sums, rows * kExpertColumns, 0.0F);
  const uint8_t* at = w.data.get() + block * w.experts * block_bytes(w.in, w.floats);
  for (int64_t e = 0; e < w.experts; ++e) {
    float most = 0;
    const float* bias = w.bias.data() + (e * w.blocks() + block) * kExpertColumns;
    for (int64_t r = 0; r < rows; ++r) {
      gate[r] = gates != nullptr ? gates[r * gate_stride + e] : 1.0F;
      most = std::max(most, gate[r]);
      for (int64_t c = 0; c < kExpertColumns; ++c) sums[r * kExpertColumns + c] += gate[r] * bias[c];
    }
    if (most < kNoGate) {
      at += block_bytes(w.in, w.floats);
      continue;
    }
    for (int64_t first = 0; first < w.in; first += kDepth) {
      const int64_t depth = std::min(kDepth, w.in - first);
      int64_t r = 0;
      for (; r + kRows <= rows; r += kRows)
        tiles_across<kWidth, kTall, kRows, Weight>(at, depth, x + r * x_stride + first, x_stride, gate + r,
                                                   sums + r * kExpertColumns);
      if (r + 3 <= rows) {
        tiles_across<kWidth, kTall, 3, Weight>(at, depth, x + r * x_stride + first, x_stride, gate + r,
                                               sums + r * kExpertColumns);
        r += 3;
      }
      for (; r < rows; ++r)
        tiles_across<kWidth, kWide, 1, Weight>(at, depth, x + r * x_stride + first, x_stride, gate + r,
                                               sums + r * kExpertColumns);
      at += part_bytes(depth, w.floats);
    }
  }
  activate<kWidth>(activation, sums, rows * kExpertColumns);
  const int64_t columns = std::min(kExpertColumns, w.out - block * kExpertColumns);
  for (int64_t r = 0; r < rows; ++r) std::copy_n(sums + r * kExpertColumns, columns, y + r * y_stride);
}

template <int kWidth, int kWide, int kTall>
INHABIT_INLINE void products(const PackedExperts& w, int64_t block, const float* x, int64_t x_stride,
                             const float* gates, int64_t gate_stride, int64_t rows, Activation activation, float* y,
                             int64_t y_stride) {
  if (w.floats)
    products_of<kWidth, kWide, kTall, float>(w, block, x, x_stride, gates, gate_stride, rows, activation, y, y_stride);
  else
    products_of<kWidth, kWide, kTall, int16_t>(w, block, x, x_stride, gates, gate_stride, rows, activation, y,
                                               y_stride);
}

template <int kWidth>
INHABIT_INLINE void units(const float* gates, float* cell, float* hidden) {
  typedef float vec __attribute__((vector_size(kWidth * sizeof(float)), aligned(4), may_alias));
  for (int i = 0; i < 16; i += kWidth) {
    const auto gate = [&](int which) { return gates + 16 * which + i; };
    vec in = *reinterpret_cast<const vec*>(gate(0)), keep = *reinterpret_cast<const vec*>(gate(1)),
        candidate = *reinterpret_cast<const vec*>(gate(2)), out = *reinterpret_cast<const vec*>(gate(3));
    nn::vector_sigmoid<kWidth>(in);
    nn::vector_sigmoid<kWidth>(keep);
    nn::vector_tanh<kWidth>(candidate);
    nn::vector_sigmoid<kWidth>(out);
    vec& c = *reinterpret_cast<vec*>(cell + i);
    c = keep * c + in * candidate;
    vec shown = c;
    nn::vector_tanh<kWidth>(shown);
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

/// Calls part(expert, block, first input, depth, place) for all parts of the packed weights, in their order.
template <class Part>
void each_part(const PackedExperts& w, uint8_t* at, const Part& part) {
  for (int64_t block = 0; block < w.blocks(); ++block)
    for (int64_t e = 0; e < w.experts; ++e)
      for (int64_t first = 0; first < w.in; first += kDepth) {
        const int64_t depth = std::min(kDepth, w.in - first);
        part(e, block, first, depth, at);
        at += part_bytes(depth, w.floats);
      }
}

/// Packs the weights of w's sizes. Returns the sum of the squares of what rounding changed.
double pack_weights(const float* weight, PackedExperts& w) {
  const std::shared_ptr<uint8_t> data =
      large_pages(static_cast<size_t>(w.blocks() * w.experts * block_bytes(w.in, w.floats)));
  double squares = 0;
  each_part(w, data.get(), [&](int64_t e, int64_t block, int64_t first, int64_t depth, uint8_t* at) {
    auto* scales = reinterpret_cast<float*>(at);
    const int64_t begin = block * kExpertColumns, columns = std::min(kExpertColumns, w.out - begin);
    for (int64_t c = 0; c < columns; ++c) {
      const float* column = weight + (e * w.out + begin + c) * w.in + first;
      if (w.floats) {
        scales[c] = 1;
        for (int64_t i = 0; i < depth; ++i) scales[kExpertColumns * (1 + i) + c] = column[i];
        continue;
      }
      auto* numbers = reinterpret_cast<int16_t*>(at + kExpertColumns * sizeof(float));
      float most = 0;
      for (int64_t i = 0; i < depth; ++i) most = std::max(most, std::abs(column[i]));
      if (most == 0) continue;
      scales[c] = most / 32767;
      for (int64_t i = 0; i < depth; ++i) {
        const float number = std::clamp(std::round(column[i] / scales[c]), -32767.0F, 32767.0F);
        numbers[i * kExpertColumns + c] = static_cast<int16_t>(number);
        const double change = static_cast<double>(number * scales[c] - column[i]);
        squares += change * change;
      }
    }
  });
  w.data = data;
  return squares;
}

}  // namespace

PackedExperts pack_experts(const float* weight, const float* bias, int64_t experts, int64_t out, int64_t in) {
  PackedExperts w;
  w.experts = experts;
  w.in = in;
  w.out = out;
  const int64_t padded = w.blocks() * kExpertColumns;
  w.bias.assign(static_cast<size_t>(experts * padded), 0.0F);
  for (int64_t e = 0; e < experts; ++e) std::copy_n(bias + e * out, out, w.bias.data() + e * padded);
  double all = 0;
  for (int64_t i = 0; i < w.numbers(); ++i) all += static_cast<double>(weight[i]) * static_cast<double>(weight[i]);
  if (!(pack_weights(weight, w) <= kRounding * kRounding * all)) {
    w.floats = true;
    pack_weights(weight, w);
  }
  return w;
}

void expert_products(const PackedExperts& w, int64_t block, const float* x, int64_t x_stride, const float* gates,
                     int64_t gate_stride, int64_t rows, Activation activation, float* y, int64_t y_stride) {
  for_simd_level(products_avx512, products_avx2, products<4, 8, 2>)(w, block, x, x_stride, gates, gate_stride, rows,
                                                                    activation, y, y_stride);
}

void lstm_units(const float* gates, float* cell, float* hidden) {
  for_simd_level(units_avx512, units_avx2, units<4>)(gates, cell, hidden);
}

}  // namespace inhabit::interact
