#pragma once
#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/residual.h"

/// Sizes small enough to build and run in a test.
inline inhabit::inbetween::Config small_inbetween_config() {
  inhabit::inbetween::Config c;
  c.preset = "small";
  c.frames = 13;
  c.padded = 16;
  c.width = 16;
  c.multipliers = {1, 2};
  c.scene_encoder = {12, 24, 2, 2, 8, 32};
  c.anchors = 6;
  c.diffusion_steps = 50;
  return c;
}

/// Weights of no training, none of them zero; in evaluation mode.
inline inhabit::inbetween::Denoiser untrained(const inhabit::inbetween::Config& config) {
  torch::manual_seed(3);
  inhabit::inbetween::Denoiser network(config);
  const torch::NoGradGuard no_gradients;
  for (torch::Tensor& p : network->parameters()) p.add_(torch::randn_like(p), 0.1);
  network->eval();
  return network;
}

/// Residual motion: small sizes, weights of no training. @param deviation largest of what it moves beyond the baseline
inline inhabit::inbetween::Networks residual_networks(double deviation = 0.1) {
  inhabit::inbetween::Networks out;
  out.config = inhabit::inbetween::preset("compact");
  out.config.width = 32;
  out.config.multipliers = {1, 1};
  out.network = untrained(out.config);
  torch::manual_seed(6);
  out.residual_table = torch::rand({inhabit::inbetween::kScaleRows, inhabit::inbetween::kResidualFeatures}) * deviation;
  out.residual_table[0].zero_();
  return out;
}

/// What a network sees of `batch` random clips.
struct NetworkInput {
  torch::Tensor x, mask, occupancy, offsets, keys, shape, steps;

  NetworkInput(const inhabit::inbetween::Config& c, int64_t batch) {
    using namespace inhabit;
    using namespace inhabit::inbetween;
    torch::manual_seed(5);
    x = torch::randn({batch, kFeatureCount, c.frames});
    keys = torch::zeros({batch, c.frames});
    for (const int64_t key : {0, 5, c.frames - 1}) keys.select(1, key).fill_(1);
    mask = keys.unsqueeze(1).expand({batch, c.mask_channels(), c.frames});
    const int64_t side = c.scene_encoder.side;
    occupancy = torch::where(torch::rand({batch, side / 2, side, side}) < 0.2, 1.F, -1.F);
    offsets = torch::randn({batch, c.anchors, 3, c.frames});
    shape = torch::rand({batch, kShapeFeatures});
    steps = torch::randint(0, c.diffusion_steps, {batch}, torch::kInt64);
  }
  torch::Tensor through(inhabit::inbetween::Denoiser network) const {
    return network->forward(x, mask, network->embed_offsets(offsets, keys), steps,
                            network->embed_scene(occupancy) + network->embed_shape(shape));
  }
};
