#pragma once
#include <cstdint>
#include <memory>
#include <vector>

namespace inhabit::interact {

/// Columns handled together, and rows at most.
inline constexpr int64_t kExpertColumns = 64, kExpertRows = 48;

/// What becomes of a layer's outputs.
enum class Activation { kNone, kElu, kLeaky };
/// Slope under 0 of kLeaky.
inline constexpr float kLeak = 0.05F;

/// Experts' gates under this are taken for 0: softmax leaves none exactly so, and their weights need not be read.
inline constexpr float kNoGate = 1e-6F;

/// A linear layer of several experts (or of one) for inference. In 16 bits each weight is a whole number times a scale
/// that it shares with up to 63 others of its column: half the memory that a frame reads, which is what bounds its
/// time.
struct PackedExperts {
  int64_t experts = 1, in = 0, out = 0;
  bool floats = false;                  ///< weights too uneven for 16 bits stay as they are
  std::shared_ptr<const uint8_t> data;  ///< block of columns by block, expert by expert, 64 inputs by 64 inputs
  std::vector<float> bias;              ///< (experts, blocks() * kExpertColumns)

  int64_t blocks() const { return (out + kExpertColumns - 1) / kExpertColumns; }
  int64_t numbers() const { return experts * in * out; }
};

/// What rounding to 16 bits may change of a layer's weights, as root mean square relative to that of the weights. Five
/// such layers in a row, as PoseNet's, then are within 1e-4 of the largest output.
inline constexpr double kRounding = 3e-5;

/// 16 bits where they lose no more than kRounding, else floats.
/// @param weight (experts, out, in); @param bias (experts, out).
PackedExperts pack_experts(const float* weight, const float* bias, int64_t experts, int64_t out, int64_t in);

/// Columns [64 block, 64 block + 64), as many as there are, of y[r] = activation(sum over experts of gate (bias + W
/// x[r])).
/// @param gates of each row, `gate_stride` apart; nullptr where there is one expert, whose gate is 1.
/// @param rows at most kExpertRows. @param y where the block's first column goes, rows `y_stride` apart.
void expert_products(const PackedExperts& w, int64_t block, const float* x, int64_t x_stride, const float* gates,
                     int64_t gate_stride, int64_t rows, Activation activation, float* y, int64_t y_stride);

/// Long short-term memory (PyTorch's equations) of 16 units: cell and hidden are moved on.
/// @param gates 16 each of input, forget, cell and output, before their activation.
void lstm_units(const float* gates, float* cell, float* hidden);

}  // namespace inhabit::interact
