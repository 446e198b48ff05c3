#pragma once
#include <torch/torch.h>

#include <vector>

namespace inhabit::inbetween {

/// Groups of the group norms, taps of the convolutions.
inline constexpr int64_t kNormGroups = 8,  ///< of the channels
    kTaps = 5;                             ///< frames

/// A convolution over time and a group norm, (B, C, T) to (B, C', T).
struct ConvNormImpl : torch::nn::Module {
  /// @param in, out channels, C and C'; C' a multiple of kNormGroups.
  ConvNormImpl(int64_t in, int64_t out);
  /// In float32, whatever the products are made in.
  torch::Tensor forward(const torch::Tensor& x) { return norm(conv(x).to(torch::kFloat32)); }

  torch::nn::Conv1d conv{nullptr};     ///< kTaps taps, zeros beyond the ends
  torch::nn::GroupNorm norm{nullptr};  ///< of C' channels in kNormGroups groups
};
TORCH_MODULE(ConvNorm);

/// Residual block of two convolutions; the first one's norm is scaled and shifted by the embedding (adaptive group
/// norm). Starts as the skip connection alone.
struct TemporalBlockImpl : torch::nn::Module {
  /// @param in, out channels, C and C'; @param embedding its length E.
  TemporalBlockImpl(int64_t in, int64_t out, int64_t embedding);
  /// @param embedding (B, E), after its activation.
  torch::Tensor forward(const torch::Tensor& x, const torch::Tensor& embedding);

  ConvNorm first{nullptr};                 ///< C to C' channels
  ConvNorm second{nullptr};                ///< C' to C', its convolution zero at the start
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
  /// What the output is read from: (B, C, T), C the channels of the first level.
  torch::Tensor features(torch::Tensor x, const torch::Tensor& embedding);

  /// A level on the way down.
  struct Down {
    TemporalBlock first{nullptr};      ///< channels of the level above to its own
    TemporalBlock second{nullptr};     ///< its own to its own; seen by the level up of its length
    torch::nn::Conv1d halve{nullptr};  ///< none at the last level
  };
  /// A level on the way up.
  struct Up {
    TemporalBlock first{nullptr};               ///< its own channels and those of its level down to the next level's
    TemporalBlock second{nullptr};              ///< channels of the next level to the same
    torch::nn::ConvTranspose1d twice{nullptr};  ///< doubles the frames
  };
  torch::nn::Linear embed_in{nullptr};        ///< width to 4 width, of the embedding; Mish follows
  torch::nn::Linear embed_out{nullptr};       ///< 4 width to width; Mish follows
  std::vector<Down> downs;                    ///< (levels) from all frames to fewest
  TemporalBlock middle[2]{nullptr, nullptr};  ///< at the fewest frames, one after the other
  std::vector<Up> ups;                        ///< (levels - 1) from fewest frames to all
  ConvNorm last{nullptr};                     ///< on the channels of the first level; Mish follows
  torch::nn::Conv1d out_conv{nullptr};        ///< channels of the first level to `out`, zero at the start
};
TORCH_MODULE(TemporalUnet);

}  // namespace inhabit::inbetween
