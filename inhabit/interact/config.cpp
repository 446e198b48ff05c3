#include "inhabit/interact/config.h"

#include <cmath>
#include <numbers>

#include "inhabit/error.h"
#include "inhabit/io/config_fields.h"

namespace inhabit::interact {
namespace {

constexpr auto fields = [](auto& c, const auto& visit) {
  visit("preset", c.preset);
  visit("rate", c.rate);
  visit("joints", c.joints);
  visit("past_keys", c.past_keys);
  visit("future_keys", c.future_keys);
  visit("key_step", c.key_step);
  visit("actions", c.actions);
  visit("ego_rings", c.ego_rings);
  visit("ego_layers", c.ego_layers);
  visit("chair_grid", c.chair_grid);
  visit("seated_habits", c.seated_habits);
  visit("encoders", c.encoders);
  visit("encoder_layers", c.encoder_layers);
  visit("experts", c.experts);
  visit("hidden", c.hidden);
  visit("gating_hidden", c.gating_hidden);
  visit("control_encoder", c.control_encoder);
  visit("control_hidden", c.control_hidden);
  visit("control_layers", c.control_layers);
  visit("contact_hidden", c.contact_hidden);
  visit("contact_code", c.contact_code);
  visit("contact_z", c.contact_z);
  visit("training.pose_steps", c.training.pose_steps);
  visit("training.rollout_steps", c.training.rollout_steps);
  visit("training.rollout_frames", c.training.rollout_frames);
  visit("training.rollout_rate", c.training.rollout_rate);
  visit("training.rollout_average", c.training.rollout_average);
  visit("training.rollout_hand_weight", c.training.rollout_hand_weight);
  visit("training.control_steps", c.training.control_steps);
  visit("training.contact_steps", c.training.contact_steps);
  visit("training.batch", c.training.batch);
  visit("training.pose_rate", c.training.pose_rate);
  visit("training.control_rate", c.training.control_rate);
  visit("training.contact_rate", c.training.contact_rate);
  visit("training.pose_decay", c.training.pose_decay);
  visit("training.warmup", c.training.warmup);
  visit("training.pose_floor", c.training.pose_floor);
  visit("training.control_floor", c.training.control_floor);
  visit("training.contact_floor", c.training.contact_floor);
  visit("training.dropout", c.training.dropout);
  visit("training.sense_noise", c.training.sense_noise);
  visit("training.mirrored", c.training.mirrored);
  visit("training.control_frames", c.training.control_frames);
  visit("training.trajectory_weight", c.training.trajectory_weight);
  visit("training.phase_weight", c.training.phase_weight);
  visit("training.straight_weight", c.training.straight_weight);
  visit("training.first_point_weight", c.training.first_point_weight);
  visit("training.sampling_from", c.training.sampling_from);
  visit("training.sampling_to", c.training.sampling_to);
  visit("training.contact_beta", c.training.contact_beta);
  visit("inference.goal_idle", c.inference.goal_idle);
  visit("inference.goal_walk", c.inference.goal_walk);
  visit("inference.goal_sit", c.inference.goal_sit);
  visit("inference.contact_spread", c.inference.contact_spread);
  visit("baselines.samp_z", c.baselines.samp_z);
  visit("baselines.samp_hidden", c.baselines.samp_hidden);
  visit("baselines.samp_code", c.baselines.samp_code);
  visit("baselines.samp_experts", c.baselines.samp_experts);
  visit("baselines.samp_gating_hidden", c.baselines.samp_gating_hidden);
  visit("baselines.samp_beta", c.baselines.samp_beta);
};

void check_training(const Config::Training& t, const ConfigCheck& check) {
  for (const auto& [name, steps] : {std::pair("training.pose_steps", t.pose_steps),
                                    {"training.rollout_steps", t.rollout_steps},
                                    {"training.control_steps", t.control_steps},
                                    {"training.contact_steps", t.contact_steps}})
    check.within(name, steps, 0, 1e8);
  check.within("training.batch", t.batch, 1, 100'000);
  for (const auto& [name, number] : {std::pair("training.pose_rate", t.pose_rate),
                                     {"training.rollout_rate", t.rollout_rate},
                                     {"training.rollout_hand_weight", t.rollout_hand_weight},
                                     {"training.control_rate", t.control_rate},
                                     {"training.contact_rate", t.contact_rate},
                                     {"training.pose_decay", t.pose_decay},
                                     {"training.trajectory_weight", t.trajectory_weight},
                                     {"training.phase_weight", t.phase_weight},
                                     {"training.straight_weight", t.straight_weight},
                                     {"training.first_point_weight", t.first_point_weight},
                                     {"training.contact_beta", t.contact_beta}})
    check.within(name, number, 0, 1e6);
  for (const auto& [name, fraction] : {std::pair("training.warmup", t.warmup),
                                       {"training.pose_floor", t.pose_floor},
                                       {"training.control_floor", t.control_floor},
                                       {"training.contact_floor", t.contact_floor},
                                       {"training.sense_noise", t.sense_noise}})
    check.within(name, fraction, 0, 1);
  check.within("training.rollout_average", t.rollout_average, 0, 0.999'999);
  check.within("training.rollout_frames", t.rollout_frames, 1, 10'000);
  check.within("training.dropout", t.dropout, 0, 0.99);
  check.within("training.control_frames", t.control_frames, 2, 10'000);
  check.within("training.sampling_to", t.sampling_to, 0, 1);
  check.within("training.sampling_from", t.sampling_from, 0, t.sampling_to);
}

}  // namespace

int64_t Config::ego_points() const {
  int64_t points = 0;
  for (int ring = 0; ring < ego_rings; ++ring) points += std::lround(2 * std::numbers::pi * ring);
  return points * ego_layers;
}

Config preset(const std::string& name) {
  Config c;
  c.preset = name;
  if (name == "compact") {
    c.seated_habits = true;
    c.encoders = {192, 64, 128, 192, 64};
    c.encoder_layers = 2;
    c.experts = 6;
    c.hidden = 256;
    c.gating_hidden = 64;
    c.control_encoder = 96;
    c.control_hidden = 256;
    c.contact_hidden = 256;
    c.training.pose_steps = 60000;
    c.training.rollout_steps = 5000;
    c.training.rollout_rate = 3e-4;
    c.training.rollout_frames = 24;
    c.training.rollout_hand_weight = 4;
    c.training.sense_noise = 0.5;
    c.training.control_steps = 3000;
    c.training.trajectory_weight = 2;  // as released the plan stays the straight line, which nobody's hand moves along
    c.training.straight_weight = 0.1;
    c.training.contact_steps = 6000;
    c.training.contact_beta = 0.004;  // with more z says too little
    c.training.pose_rate = 1e-3;      // narrower networks learn as well with larger steps, and sooner
    c.training.pose_floor = 0.01;
    c.training.warmup = 0.02;
    c.training.dropout = 0.1;
    c.training.contact_floor = 0.01;
    c.baselines.samp_hidden = 256;
    c.baselines.samp_experts = 6;
    c.baselines.samp_gating_hidden = 64;
  } else if (name != "paper") {
    throw Error("preset '" + name + "'", "unknown; there are paper and compact");
  }
  return c;
}

std::string to_json(const Config& config) { return fields_to_json(config, fields).dump(); }

Config config_from_json(const std::string& text, const std::string& subject) {
  return inhabit::config_from_json<Config>(text, subject, fields);
}

void set_fields(Config& c, const std::vector<std::string>& settings) { inhabit::set_fields(settings, fields, c); }

void validate(const Config& c, const std::string& subject) {
  const ConfigCheck check{subject};
  check.within("rate", c.rate, 1, 240);
  check.within("joints", c.joints, 1, 1000);
  check.within("past_keys", c.past_keys, 0, 100);
  check.within("future_keys", c.future_keys, 1, 100);
  check.within("key_step", c.key_step, 1, 240);
  check.within("actions", c.actions, 1, 64);
  check.within("ego_rings", c.ego_rings, 2, 64);
  check.within("ego_layers", c.ego_layers, 1, 64);
  check.within("chair_grid", c.chair_grid, 1, 32);
  check.holds(c.encoders.size() == 5, "encoders");
  for (const int width : c.encoders) check.within("encoders", width, 1, 8192);
  for (const auto& [name, width] : {std::pair("hidden", c.hidden),
                                    {"gating_hidden", c.gating_hidden},
                                    {"control_encoder", c.control_encoder},
                                    {"control_hidden", c.control_hidden},
                                    {"contact_hidden", c.contact_hidden},
                                    {"contact_code", c.contact_code},
                                    {"baselines.samp_hidden", c.baselines.samp_hidden},
                                    {"baselines.samp_code", c.baselines.samp_code},
                                    {"baselines.samp_gating_hidden", c.baselines.samp_gating_hidden}})
    check.within(name, width, 1, 4096);
  check.within("encoder_layers", c.encoder_layers, 1, 16);
  check.within("experts", c.experts, 1, 64);
  check.within("baselines.samp_experts", c.baselines.samp_experts, 1, 64);
  check.within("control_layers", c.control_layers, 1, 16);
  check.within("contact_z", c.contact_z, 1, 1024);
  check.within("baselines.samp_z", c.baselines.samp_z, 1, 1024);
  check.within("baselines.samp_beta", c.baselines.samp_beta, 0, 1e6);
  check_training(c.training, check);
  for (const auto& [name, fraction] : {std::pair("inference.goal_idle", c.inference.goal_idle),
                                       {"inference.goal_walk", c.inference.goal_walk},
                                       {"inference.goal_sit", c.inference.goal_sit}})
    check.within(name, fraction, 0, 1);
  check.within("inference.contact_spread", c.inference.contact_spread, 0, 10);
}

}  // namespace inhabit::interact
