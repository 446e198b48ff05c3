#pragma once
#include <torch/torch.h>

#include <vector>

#include "inhabit/inbetween/config.h"

namespace inhabit::inbetween {

/// Global scene features (3.1): a vision transformer over the occupancy, whose height cells are the channels of an
/// image seen from above.
struct SceneEncoderImpl : torch::nn::Module {
  /// @param out length of the embedding.
  SceneEncoderImpl(const SceneEncoderSpec& spec, int64_t out);
  /// @param occupancy (B, side / 2, side, side), -1 free or 1 occupied. @return (B, out)
  torch::Tensor forward(const torch::Tensor& occupancy);

 private:
  struct Layer {
    torch::nn::LayerNorm attention_norm{nullptr}, mlp_norm{nullptr};
    torch::nn::Linear to_qkv{nullptr}, to_out{nullptr}, widen{nullptr}, narrow{nullptr};
  };
  torch::Tensor attend(Layer& layer, const torch::Tensor& tokens);
  torch::Tensor dropped(const torch::Tensor& x) const;

  SceneEncoderSpec spec_;
  torch::Tensor class_token_, positions_;  // (1, W), (1 + patches, W)
  torch::nn::LayerNorm patch_norm_{nullptr}, token_norm_{nullptr}, last_norm_{nullptr};
  torch::nn::Linear embed_{nullptr}, head_{nullptr};
  std::vector<Layer> layers_;
};
TORCH_MODULE(SceneEncoder);

}  // namespace inhabit::inbetween
