#pragma once
#include <torch/torch.h>

#include <vector>

namespace inhabit::inbetween {

/// Groups of the group norms, taps of the convolutions.
inline constexpr int64_t kNormGroups = 8, kTaps = 5;

/// A convolution over time and a group norm, (B, C, T) to (B, C', T).
struct ConvNormImpl : torch::nn::Module {
  ConvNormImpl(int64_t in, int64_t out);
  /// In float32, whatever the products are made in.
  torch::Tensor forward(const torch::Tensor& x) { return norm(conv(x).to(torch::kFloat32)); }

  torch::nn::Conv1d conv{nullptr};
  torch::nn::GroupNorm norm{nullptr};
};
TORCH_MODULE(ConvNorm);

/// Residual block of two convolutions; the first one's norm is scaled and shifted by the embedding (adaptive group
/// norm). Starts as the skip connection alone.
struct TemporalBlockImpl : torch::nn::Module {
  TemporalBlockImpl(int64_t in, int64_t out, int64_t embedding);
  /// @param embedding (B, E), after its activation.
  torch::Tensor forward(const torch::Tensor& x, const torch::Tensor& embedding);

  ConvNorm first{nullptr}, second{nullptr};
  torch::nn::Linear scale_shift{nullptr};  ///< (2 C'): scales less one, then shifts
  torch::nn::Conv1d around{nullptr};       ///< the skip connection where channels change; else it is the input itself
};
TORCH_MODULE(TemporalBlock);

/// 1D U-Net over time. Levels down halve the frames, levels up double them; each level up also sees the output of the
/// level down of its own length (skip connection).
struct TemporalUnetImpl : torch::nn::Module {
  /// @param in, out channels; @param width of the embedding and of a level with multiplier 1.
  TemporalUnetImpl(int64_t in, int64_t out, int64_t width, const std::vector<int>& multipliers);
  /// @param x (B, in, T), T a multiple of 2^(levels - 1). @param embedding (B, width). @return (B, out, T)
  torch::Tensor forward(torch::Tensor x, const torch::Tensor& embedding);

  struct Down {
    TemporalBlock first{nullptr}, second{nullptr};
    torch::nn::Conv1d halve{nullptr};  ///< none at the last level
  };
  struct Up {
    TemporalBlock first{nullptr}, second{nullptr};
    torch::nn::ConvTranspose1d twice{nullptr};
  };
  torch::nn::Linear embed_in{nullptr}, embed_out{nullptr};
  std::vector<Down> downs;
  TemporalBlock middle[2]{nullptr, nullptr};
  std::vector<Up> ups;
  ConvNorm last{nullptr};
  torch::nn::Conv1d out_conv{nullptr};
};
TORCH_MODULE(TemporalUnet);

}  // namespace inhabit::inbetween
