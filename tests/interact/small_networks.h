#pragma once
#include <torch/torch.h>

#include "inhabit/interact/model_file.h"

namespace inhabit::interact {

/// Narrow networks: widths that are no multiple of a vector's.
inline Config small_interact_config() {
  Config c;
  c.preset = "small";
  c.encoders = {20, 9, 12, 17, 5};
  c.encoder_layers = 2;
  c.experts = 3;
  c.hidden = 27;
  c.gating_hidden = 11;
  c.ego_rings = 3;
  c.ego_layers = 2;
  c.chair_grid = 2;
  c.seated_habits = true;
  c.control_encoder = 7;
  c.control_hidden = 19;
  c.contact_hidden = 15;
  c.contact_code = 8;
  c.contact_z = 4;
  c.baselines.samp_z = 6;
  c.baselines.samp_hidden = 18;
  c.baselines.samp_code = 7;
  c.baselines.samp_experts = 4;
  c.baselines.samp_gating_hidden = 10;
  return c;
}

/// All of them, in evaluation mode.
inline Networks untrained_networks(const Config& c) {
  torch::manual_seed(1);
  Networks n;
  n.config = c;
  const PoseSizes sizes = pose_sizes(c);
  n.input_scale = {torch::randn({sizes.row}), torch::rand({sizes.row}) + 0.1};
  n.output_scale = {torch::randn({sizes.outputs}), torch::rand({sizes.outputs}) + 0.1};
  if (c.seated_habits)
    n.habits = {torch::rand({2, c.chair_size()}),
                torch::rand({2}),
                {torch::tensor({3, 7}), torch::rand({7, 15})},
                {torch::tensor({2, 4, 9}), torch::rand({9, 15})}};
  n.pose = PoseNetwork(sizes);
  n.control = ControlNetwork(c);
  n.contact = ContactNetwork(c);
  n.nsm = PoseNetwork(nsm_sizes(c, false));
  n.nsm_control = PoseNetwork(nsm_sizes(c, true));
  n.samp = SampNetwork(c, false);
  n.samp_control = SampNetwork(c, true);
  n.pose->eval();
  n.control->eval();
  n.contact->eval();
  n.nsm->eval();
  n.nsm_control->eval();
  n.samp->eval();
  n.samp_control->eval();
  return n;
}

}  // namespace inhabit::interact
