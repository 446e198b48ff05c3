#include "inhabit/inbetween/network.h"

#include <cmath>

#include "inhabit/inbetween/residual_input.h"
#include "inhabit/nn/mish.h"

namespace inhabit::inbetween {

namespace tn = torch::nn;
using torch::Tensor;

DenoiserImpl::DenoiserImpl(const Config& network_config) : config(network_config) {
  const int64_t width = config.width;
  if (config.local_scene) {
    const int64_t widths[] = {3 * config.anchors, 1024, 256, 32, kLocalChannels};
    const auto layers = register_module("cond_process", std::make_shared<tn::Module>());
    for (int i = 0; i < 4; ++i)
      offset_layers[i] = layers->register_module("lin" + std::to_string(i), tn::Linear(widths[i], widths[i + 1]));
  }
  if (config.body_shape)
    shape_layer = register_module("beta_process", std::make_shared<tn::Module>())
                      ->register_module("lin0", tn::Linear(config.residual ? kBoneFeatures : kShapeFeatures, width));
  const int64_t channels = kFeatureCount + config.mask_channels() + (config.local_scene ? kLocalChannels : 0) +
                           (config.from_interpolation ? kFeatureCount : 0);
  if (config.residual) {
    stem = register_module("stem", tn::Conv1d(tn::Conv1dOptions(kResidualChannels, width, 1)));
    unet = register_module("unet", TemporalUnet(width, kResidualFeatures, width, config.multipliers));
  } else {
    unet = register_module("unet", TemporalUnet(channels, kFeatureCount, width, config.multipliers));
  }
  const auto steps = register_module("embed_timestep", std::make_shared<tn::Module>())
                         ->register_module("time_embed", std::make_shared<tn::Module>());
  step_in = steps->register_module("0", tn::Linear(width, width));
  step_out = steps->register_module("2", tn::Linear(width, width));
  if (config.global_scene)
    scene_encoder = register_module("scene_embedding", SceneEncoder(config.scene_encoder, width));
}

Tensor DenoiserImpl::embed_scene(const Tensor& occupancy) {
  if (!scene_encoder.is_empty()) return scene_encoder(occupancy);
  return torch::zeros({occupancy.size(0), config.width}, occupancy.options());
}

Tensor DenoiserImpl::embed_shape(const Tensor& shape) {
  if (!shape_layer.is_empty()) return shape_layer(shape);
  return torch::zeros({shape.size(0), config.width}, shape.options());
}

Tensor DenoiserImpl::embed_offsets(const Tensor& offsets, const Tensor& keys) {
  if (!config.local_scene) return torch::zeros({offsets.size(0), 0, offsets.size(3)}, offsets.options());
  Tensor x = (offsets.flatten(1, 2) * keys.unsqueeze(1)).transpose(1, 2);  // (B, T, 3 anchors)
  for (int i = 0; i < 4; ++i) x = i == 0 ? offset_layers[i](x) : offset_layers[i](nn::mish(x));
  return x.transpose(1, 2);
}

Tensor DenoiserImpl::embed_steps(const Tensor& steps) {
  const auto options = step_in->weight.options().requires_grad(false);
  const Tensor rate = torch::exp(torch::arange(0, config.width, 2, options) * (-std::log(10000.0) / config.width));
  const Tensor angle = steps.to(options).unsqueeze(1) * rate;
  // Sine and cosine of each rate side by side.
  return step_out(torch::silu(step_in(torch::stack({angle.sin(), angle.cos()}, 2).flatten(1))));
}

Tensor DenoiserImpl::forward(const Tensor& x, const Tensor& mask, const Tensor& local, const Tensor& steps,
                             const Tensor& embedding) {
  const int64_t frames = x.size(2);
  const Tensor all = torch::constant_pad_nd(torch::cat({x, mask, local}, 1), {0, config.padded - frames});
  return unet(all, embed_steps(steps) + embedding).slice(2, 0, frames);
}

Tensor DenoiserImpl::residual(const Tensor& input, const Tensor& steps, const Tensor& embedding) {
  return unet->out_conv(features(input, steps, embedding));
}

Tensor DenoiserImpl::features(const Tensor& input, const Tensor& steps, const Tensor& embedding) {
  const int64_t frames = input.size(2);
  const Tensor all = torch::constant_pad_nd(stem(input).to(torch::kFloat32), {0, config.padded - frames});
  return unet->features(all, embed_steps(steps) + embedding).slice(2, 0, frames);
}

}  // namespace inhabit::inbetween
