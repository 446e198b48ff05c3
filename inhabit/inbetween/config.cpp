#include "inhabit/inbetween/config.h"

#include "inhabit/error.h"
#include "inhabit/io/config_fields.h"

namespace inhabit::inbetween {
namespace {

using nlohmann::json;

constexpr int kMostPatches = 32;  // along a side: attention costs the fourth power of it

constexpr auto fields = [](auto& c, const auto& visit) {
  visit("preset", c.preset);
  visit("rate", c.rate);
  visit("frames", c.frames);
  visit("padded", c.padded);
  visit("width", c.width);
  visit("multipliers", c.multipliers);
  visit("scene_patch", c.scene_encoder.patch);
  visit("scene_width", c.scene_encoder.width);
  visit("scene_depth", c.scene_encoder.depth);
  visit("scene_heads", c.scene_encoder.heads);
  visit("scene_head_width", c.scene_encoder.head_width);
  visit("scene_mlp", c.scene_encoder.mlp);
  visit("scene_side", c.scene_encoder.side);
  visit("anchors", c.anchors);
  visit("diffusion_steps", c.diffusion_steps);
  visit("t_star", c.t_star);
  visit("global_scene", c.global_scene);
  visit("local_scene", c.local_scene);
  visit("body_shape", c.body_shape);
  visit("keys_seen", c.keys_seen);
  visit("partial_keys", c.partial_keys);
  visit("from_interpolation", c.from_interpolation);
  visit("around_obstacles", c.around_obstacles);
  visit("residual", c.residual);
  visit("along_detours", c.along_detours);
  visit("training.steps", c.training.steps);
  visit("training.batch", c.training.batch);
  visit("training.learning_rate", c.training.learning_rate);
  visit("training.weight_decay", c.training.weight_decay);
  visit("training.average", c.training.average);
  visit("training.stride", c.training.stride);
  visit("training.bfloat16", c.training.bfloat16);
  visit("training.joints_weight", c.training.joints_weight);
  visit("training.velocity_weight", c.training.velocity_weight);
  visit("training.feet_weight", c.training.feet_weight);
  visit("training.rest_rotation", c.training.rest_rotation);
  visit("training.scene_dropout", c.training.scene_dropout);
  visit("training.noisiest", c.training.noisiest);
  visit("training.far_keys", c.training.far_keys);
  visit("training.recorded", c.training.recorded);
  visit("training.time_warp", c.training.time_warp);
  visit("training.blocked", c.training.blocked);
  visit("training.way_around", c.training.way_around);
  visit("training.walked", c.training.walked);
  visit("training.sliding_weight", c.training.sliding_weight);
  visit("training.swinging_weight", c.training.swinging_weight);
  visit("training.clearance_weight", c.training.clearance_weight);
  visit("training.noisy", c.training.noisy);
  visit("training.penetration_weight", c.training.penetration_weight);
  visit("training.deployed_steps", c.training.deployed_steps);
  visit("training.deployed_learning_rate", c.training.deployed_learning_rate);
  visit("training.path_steps", c.training.path_steps);
  visit("training.path_batch", c.training.path_batch);
  visit("training.path_learning_rate", c.training.path_learning_rate);
  visit("training.contact_steps", c.training.contact_steps);
  visit("training.contact_learning_rate", c.training.contact_learning_rate);
  visit("training.warmup", c.training.schedule.warmup);
  visit("training.rate_floor", c.training.schedule.floor);
  visit("inference.guidance", c.inference.guidance);
  visit("inference.steps", c.inference.steps);
  visit("inference.noisy_keys", c.inference.noisy_keys);
};

}  // namespace

Config preset(const std::string& name) {
  Config config;
  config.preset = name;
  if (name == "features") {
    config.width = 96;
    config.multipliers = {1, 2, 2};
    config.scene_encoder = {6, 128, 3, 4, 32, 256};
    config.training.velocity_weight = 100;
    config.training.feet_weight = 300;
    config.training.rest_rotation = 8;
    config.partial_keys = true;
    config.from_interpolation = true;
    config.around_obstacles = true;
  } else if (name == "compact") {
    config.width = 96;
    config.multipliers = {1, 2, 2};
    config.partial_keys = true;
    config.residual = true;
    config.along_detours = true;
    config.global_scene = config.local_scene = false;
    config.inference.guidance = 1;
    config.inference.steps = 2;
    config.training.steps = 60000;
    config.training.stride = 15;
    config.training.joints_weight = 1;
    config.training.velocity_weight = 0.5;
    config.training.feet_weight = 0.5;
    config.training.bfloat16 = true;
    config.training.average = 0.999;
    config.training.noisy = 0.3;
    config.training.walked = 0.6;
    config.training.sliding_weight = 8;
  } else if (name != "paper") {
    throw Error("preset '" + name + "'", "unknown; there are compact, paper and features");
  }
  return config;
}

std::string to_json(const Config& config) { return fields_to_json(config, fields).dump(); }

Config config_from_json(const std::string& text, const std::string& subject) {
  return inhabit::config_from_json<Config>(text, subject, fields);
}

Config released_config(const std::map<std::string, std::string>& metadata, const std::string& subject) {
  Config config;
  config.preset = "released";
  /// The values of the metadata are JSON themselves.
  const auto value = [&](const char* key) {
    const auto found = metadata.find(key);
    if (found == metadata.end()) throw Error(subject, std::string("metadata lacks '") + key + "'");
    return json::parse(found->second, nullptr, /*allow_exceptions=*/false);
  };
  const auto set = [&](const char* name, const json& from, auto& field) {
    if (!take(from, field)) throw Error(subject, std::string("metadata: '") + name + "' has the wrong type");
  };
  set("latent_dim", value("latent_dim"), config.width);
  set("dim_mults", value("dim_mults"), config.multipliers);
  set("frames", value("frames"), config.frames);
  set("padded_frames", value("padded_frames"), config.padded);
  set("bps_points", value("bps_points"), config.anchors);
  set("t_star", value("t_star"), config.t_star);
  set("diffusion_steps", value("diffusion_steps"), config.diffusion_steps);
  set("guidance", value("guidance"), config.inference.guidance);
  int features = 0, channels = 0;
  set("features", value("features"), features);
  const json vit = value("vit");
  if (!vit.is_object()) throw Error(subject, "metadata: 'vit' has the wrong type");
  const auto of_vit = [&](const char* key, auto& field) { set(key, vit.value(key, json()), field); };
  of_vit("image", config.scene_encoder.side);
  of_vit("channels", channels);
  of_vit("patch", config.scene_encoder.patch);
  of_vit("dim", config.scene_encoder.width);
  of_vit("depth", config.scene_encoder.depth);
  of_vit("heads", config.scene_encoder.heads);
  of_vit("mlp", config.scene_encoder.mlp);
  if (features != kFeatureCount || channels != config.scene_encoder.height())
    throw Error(subject, "metadata: features or occupancy of another size");
  validate(config, subject);
  return config;
}

void set_fields(Config& c, const std::vector<std::string>& settings) { inhabit::set_fields(settings, fields, c); }

void validate(const Config& c, const std::string& subject) {
  const ConfigCheck check{subject};
  check.within("rate", c.rate, 1, 240);
  check.within("frames", c.frames, 2, 4096);
  check.within("padded", c.padded, c.frames, 8192);
  check.within("width", c.width, 8, 1024);
  check.holds(c.width % 2 == 0, "width");
  check.within("multipliers", static_cast<double>(c.multipliers.size()), 2, 6);
  for (const int m : c.multipliers) {
    check.within("multipliers", m, 1, 16);
    check.within("multipliers", m * c.width, 8, 1024);
    check.holds(m * c.width % 8 == 0, "multipliers");  // group norm's groups
  }
  check.holds(c.padded % (1 << (c.multipliers.size() - 1)) == 0, "padded");
  check.within("scene_side", c.scene_encoder.side, 8, 192);
  check.holds(c.scene_encoder.side % 4 == 0, "scene_side");
  check.within("scene_patch", c.scene_encoder.patch, 2, c.scene_encoder.side);
  check.holds(c.scene_encoder.side % c.scene_encoder.patch == 0, "scene_patch");
  check.holds(c.scene_encoder.side / c.scene_encoder.patch <= kMostPatches, "scene_patch");
  check.within("scene_width", c.scene_encoder.width, 1, 2048);
  check.within("scene_depth", c.scene_encoder.depth, 1, 24);
  check.within("scene_heads", c.scene_encoder.heads, 1, 64);
  check.within("scene_head_width", c.scene_encoder.head_width, 1, 256);
  check.within("scene_mlp", c.scene_encoder.mlp, 1, 8192);
  check.within("anchors", c.anchors, 1, 1024);
  check.within("diffusion_steps", c.diffusion_steps, 2, 10000);
  check.within("t_star", c.t_star, 0, c.diffusion_steps);
  check.holds(c.keys_seen || !(c.local_scene || c.from_interpolation || c.residual || c.t_star > 0),
              "keys_seen");  // these are of keys
  check.within("inference.guidance", c.inference.guidance, 0, 100);
  check.within("inference.steps", c.inference.steps, 1, c.diffusion_steps);
  check.holds(c.takes_noise() || !c.inference.noisy_keys, "inference.noisy_keys");
  check.within("training.steps", c.training.steps, 1, 1e8);
  check.within("training.batch", c.training.batch, 1, 100'000);
  check.within("training.stride", c.training.stride, 1, 100'000);
  check.within("training.learning_rate", c.training.learning_rate, 0, 100);
  check.within("training.weight_decay", c.training.weight_decay, 0, 100);
  check.within("training.average", c.training.average, 0, 1 - 1e-9);
  check.within("training.joints_weight", c.training.joints_weight, 0, 1000);
  check.within("training.velocity_weight", c.training.velocity_weight, 0, 1000);
  check.within("training.feet_weight", c.training.feet_weight, 0, 1000);
  check.within("training.rest_rotation", c.training.rest_rotation, 0, 90);
  check.within("training.scene_dropout", c.training.scene_dropout, 0, 1);
  check.within("training.noisiest", c.training.noisiest, 0, 1);
  check.within("training.far_keys", c.training.far_keys, 0, 1);
  check.within("training.recorded", c.training.recorded, 0, 1);
  check.within("training.time_warp", c.training.time_warp, 0, 1);
  check.within("training.blocked", c.training.blocked, 0, 1);
  check.within("training.way_around", c.training.way_around, 0, 1);
  check.within("training.walked", c.training.walked, 0, 1);
  check.within("training.sliding_weight", c.training.sliding_weight, 0, 1000);
  check.within("training.swinging_weight", c.training.swinging_weight, 0, 1000);
  check.within("training.noisy", c.training.noisy, 0, 1);
  check.within("training.penetration_weight", c.training.penetration_weight, 0, 1000);
  check.within("training.clearance_weight", c.training.clearance_weight, 0, 1000);
  check.within("training.deployed_steps", c.training.deployed_steps, 1, 1e8);
  check.within("training.deployed_learning_rate", c.training.deployed_learning_rate, 0, 100);
  check.within("training.path_steps", c.training.path_steps, 1, 1e8);
  check.within("training.path_batch", c.training.path_batch, 1, 100'000);
  check.within("training.path_learning_rate", c.training.path_learning_rate, 0, 100);
  check.within("training.contact_steps", c.training.contact_steps, 1, 1e8);
  check.within("training.contact_learning_rate", c.training.contact_learning_rate, 0, 100);
  check_schedule(check, c.training.schedule);
}

void require_noise_aware(const Config& config, const std::string& file) {
  // Imputation from T* on cleans keys of features alone.
  const bool aware = config.residual ? config.inference.noisy_keys : config.t_star > 0;
  if (!aware) throw Error(file, "was not trained on noisy key frames");
}

}  // namespace inhabit::inbetween
