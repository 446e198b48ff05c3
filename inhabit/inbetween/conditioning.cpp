#include "inhabit/inbetween/conditioning.h"

#include "inhabit/inbetween/features.h"
#include "inhabit/inbetween/obstacle_detours.h"

namespace inhabit::inbetween {

using torch::Tensor;

DenoiserInput denoiser_input(const Networks& networks, const Conditioning& c) {
  const Config& config = networks.config;
  Denoiser network = networks.network;
  const int64_t batch = c.groups.size(0);
  const Tensor groups = config.keys_seen ? c.groups : torch::zeros_like(c.groups);
  DenoiserInput out;
  out.mask = config.partial_keys ? groups.transpose(1, 2) : groups.amax(2).unsqueeze(1);
  out.local = network->embed_offsets(c.offsets, groups.amin(2));  // offsets need the whole pose
  out.baseline = torch::zeros({}, c.groups.options());
  if (config.from_interpolation) {
    out.baseline = along_detours(interpolated_baseline(c.constraints, networks.scale), c.detours, c.constraints.mask,
                                 networks.scale.deviation);
    out.local = torch::cat({out.local, out.baseline}, 1);
  }
  if (config.global_scene) out.scene = network->embed_scene(c.occupancy);
  out.shape =
      config.body_shape ? network->embed_shape(c.shape) : torch::zeros({batch, config.width}, c.groups.options());
  return out;
}

}  // namespace inhabit::inbetween
