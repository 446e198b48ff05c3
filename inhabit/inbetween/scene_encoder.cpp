#include "inhabit/inbetween/scene_encoder.h"

#include <cmath>

namespace inhabit::inbetween {

namespace tn = torch::nn;
using torch::Tensor;

namespace {

constexpr double kDropout = 0.1;  // of tokens, attention weights and both outputs of a layer

tn::LayerNorm layer_norm(int64_t width) { return tn::LayerNorm(tn::LayerNormOptions({width})); }

/// Registered under the places that the parts have in the release.
template <class Part>
Part at(const std::shared_ptr<tn::Module>& list, int64_t place, Part part) {
  return list->register_module(std::to_string(place), part);
}

}  // namespace

SceneEncoderImpl::SceneEncoderImpl(const SceneEncoderSpec& spec, int64_t out) : spec_(spec) {
  const int64_t across = spec.side / spec.patch, cells = spec.height() * spec.patch * spec.patch;
  const int64_t inner = static_cast<int64_t>(spec.heads) * spec.head_width;
  class_token_ = register_parameter("cls_token", torch::randn({1, spec.width}));
  positions_ = register_parameter("pos_embedding", torch::randn({across * across + 1, spec.width}));
  const auto patches = register_module("to_patch_embedding", std::make_shared<tn::Module>());
  patch_norm_ = at(patches, 1, layer_norm(cells));
  embed_ = at(patches, 2, tn::Linear(cells, spec.width));
  token_norm_ = at(patches, 3, layer_norm(spec.width));
  const auto transformer = register_module("transformer", std::make_shared<tn::Module>());
  last_norm_ = transformer->register_module("norm", layer_norm(spec.width));
  const auto list = transformer->register_module("layers", std::make_shared<tn::Module>());
  for (int64_t i = 0; i < spec.depth; ++i) {
    Layer layer;
    const auto pair = at(list, i, std::make_shared<tn::Module>());
    const auto attention = at(pair, 0, std::make_shared<tn::Module>());
    layer.attention_norm = attention->register_module("norm", layer_norm(spec.width));
    layer.to_qkv =
        attention->register_module("to_qkv", tn::Linear(tn::LinearOptions(spec.width, 3 * inner).bias(false)));
    layer.to_out =
        at(attention->register_module("to_out", std::make_shared<tn::Module>()), 0, tn::Linear(inner, spec.width));
    const auto mlp =
        at(pair, 1, std::make_shared<tn::Module>())->register_module("net", std::make_shared<tn::Module>());
    layer.mlp_norm = at(mlp, 0, layer_norm(spec.width));
    layer.widen = at(mlp, 1, tn::Linear(spec.width, spec.mlp));
    layer.narrow = at(mlp, 4, tn::Linear(spec.mlp, spec.width));
    layers_.push_back(layer);
  }
  head_ = register_module("mlp_head", tn::Linear(spec.width, out));
}

Tensor SceneEncoderImpl::dropped(const Tensor& x) const { return torch::dropout(x, kDropout, is_training()); }

Tensor SceneEncoderImpl::attend(Layer& layer, const Tensor& tokens) {
  const int64_t batch = tokens.size(0), count = tokens.size(1);
  const Tensor qkv = layer.to_qkv(layer.attention_norm(tokens))
                         .view({batch, count, 3, spec_.heads, spec_.head_width})
                         .permute({2, 0, 3, 1, 4});  // (3, B, heads, tokens, head width)
  const Tensor weights =
      dropped((torch::matmul(qkv[0], qkv[1].transpose(-1, -2)) / std::sqrt(spec_.head_width)).softmax(-1));
  const Tensor mixed = torch::matmul(weights, qkv[2]).transpose(1, 2).reshape({batch, count, -1});
  return dropped(layer.to_out(mixed));
}

Tensor SceneEncoderImpl::forward(const Tensor& occupancy) {
  const int64_t batch = occupancy.size(0), height = spec_.height(), p = spec_.patch, across = spec_.side / p;
  // Patches row by row, inside one the place first and the height last.
  const Tensor patches = occupancy.view({batch, height, across, p, across, p})
                             .permute({0, 2, 4, 3, 5, 1})
                             .reshape({batch, across * across, p * p * height});
  const Tensor embedded = token_norm_(embed_(patch_norm_(patches)).to(torch::kFloat32));
  Tensor tokens = dropped(torch::cat({class_token_.expand({batch, 1, spec_.width}), embedded}, 1) + positions_);
  for (Layer& layer : layers_) {
    tokens = tokens + attend(layer, tokens);
    tokens = tokens + dropped(layer.narrow(dropped(torch::gelu(layer.widen(layer.mlp_norm(tokens))))));
  }
  return head_(last_norm_(tokens).select(1, 0));
}

}  // namespace inhabit::inbetween
