#pragma once
#include <memory>

#include "inhabit/inbetween/network.h"

namespace inhabit::inbetween {

/// Inference-only evaluation of a denoiser on the CPU: the same outputs (to about 1e-6 of the largest) several times
/// faster. Frames are rows, so that a convolution is one matrix product over overlapping rows, with weights packed
/// once; the norms, the embedding's scale and shift and the activation are one pass.
///
/// Holds a copy of the U-Net's weights and its workspaces, which later calls reuse: one instance per thread of the
/// caller.
class FastDenoiser {
 public:
  explicit FastDenoiser(const Denoiser& network);
  ~FastDenoiser();
  FastDenoiser(FastDenoiser&&) noexcept;
  FastDenoiser& operator=(FastDenoiser&&) noexcept;

  /// As DenoiserImpl::forward() in evaluation mode, without gradients. CPU tensors.
  torch::Tensor forward(const torch::Tensor& x, const torch::Tensor& mask, const torch::Tensor& local,
                        const torch::Tensor& steps, const torch::Tensor& embedding);

  /// Classifier-free guidance at one step, w D(scene) + (1 - w) D(no scene), both in one batch (3.2).
  /// @param t the step of all. @param scene, shape (B, width) from embed_scene() and embed_shape(), once a clip.
  torch::Tensor guided(const torch::Tensor& x, const torch::Tensor& mask, const torch::Tensor& local, int64_t t,
                       const torch::Tensor& scene, const torch::Tensor& shape, double guidance);

  /// As DenoiserImpl::residual() at one step. @param input (B, kResidualChannels, T). @param embedding (B, width) of
  /// embed_shape()
  torch::Tensor residual(const torch::Tensor& input, int64_t t, const torch::Tensor& embedding);
  /// As DenoiserImpl::features() of the call before.
  torch::Tensor features() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace inhabit::inbetween
