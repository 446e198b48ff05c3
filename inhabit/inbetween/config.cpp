#include "inhabit/inbetween/config.h"

#include "inhabit/error.h"
#include "inhabit/io/config_fields.h"

namespace inhabit::inbetween {
namespace {

using nlohmann::json;

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
  visit("anchors", c.anchors);
  visit("diffusion_steps", c.diffusion_steps);
  visit("t_star", c.t_star);
  visit("guidance", c.guidance);
  visit("joints_weight", c.joints_weight);
  visit("velocity_weight", c.velocity_weight);
  visit("feet_weight", c.feet_weight);
  visit("rest_turn", c.rest_turn);
  visit("scene_dropout", c.scene_dropout);
  visit("global_scene", c.global_scene);
  visit("local_scene", c.local_scene);
  visit("body_shape", c.body_shape);
  visit("partial_keys", c.partial_keys);
  visit("from_interpolation", c.from_interpolation);
  visit("around_obstacles", c.around_obstacles);
};

}  // namespace

Config preset(const std::string& name) {
  Config config;
  config.preset = name;
  if (name == "compact") {
    config.width = 96;
    config.multipliers = {1, 2, 2};
    config.scene_encoder = {6, 128, 3, 4, 32, 256};
    config.velocity_weight = 100;
    config.feet_weight = 300;
    config.rest_turn = 8;
    config.partial_keys = true;
    config.from_interpolation = true;
    config.around_obstacles = true;
  } else if (name != "paper") {
    throw Error("preset '" + name + "'", "unknown; there are paper and compact");
  }
  return config;
}

std::string to_json(const Config& config) { return fields_to_json(config, fields).dump(); }

Config config_from_json(const std::string& text, const std::string& subject) {
  Config config;
  fields_from_json(config_object(text, subject), subject, fields, config);
  validate(config, subject);
  return config;
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
  set("guidance", value("guidance"), config.guidance);
  int features = 0, image = 0, channels = 0;
  set("features", value("features"), features);
  const json vit = value("vit");
  if (!vit.is_object()) throw Error(subject, "metadata: 'vit' has the wrong type");
  const auto of_vit = [&](const char* key, auto& field) { set(key, vit.value(key, json()), field); };
  of_vit("image", image);
  of_vit("channels", channels);
  of_vit("patch", config.scene_encoder.patch);
  of_vit("dim", config.scene_encoder.width);
  of_vit("depth", config.scene_encoder.depth);
  of_vit("heads", config.scene_encoder.heads);
  of_vit("mlp", config.scene_encoder.mlp);
  if (features != kFeatureCount || image != kSceneSide || channels != kSceneHeight)
    throw Error(subject, "metadata: features or occupancy of another size");
  validate(config, subject);
  return config;
}

void validate(const Config& c, const std::string& subject) {
  const auto check = [&](bool good, const char* name) {
    if (!good) throw Error(subject, std::string("configuration: '") + name + "' is out of range");
  };
  const auto within = [&](const char* name, double value, double low, double high) {
    check(value >= low && value <= high, name);
  };
  within("rate", c.rate, 1, 240);
  within("frames", c.frames, 2, 4096);
  within("padded", c.padded, c.frames, 8192);
  within("width", c.width, 8, 1024);
  check(c.width % 2 == 0, "width");
  within("multipliers", static_cast<double>(c.multipliers.size()), 2, 6);
  for (const int m : c.multipliers) {
    within("multipliers", m, 1, 16);
    within("multipliers", m * c.width, 8, 1024);
    check(m * c.width % 8 == 0, "multipliers");  // group norm's groups
  }
  check(c.padded % (1 << (c.multipliers.size() - 1)) == 0, "padded");
  within("scene_patch", c.scene_encoder.patch, 2, kSceneSide);
  check(kSceneSide % c.scene_encoder.patch == 0, "scene_patch");
  within("scene_width", c.scene_encoder.width, 1, 2048);
  within("scene_depth", c.scene_encoder.depth, 1, 24);
  within("scene_heads", c.scene_encoder.heads, 1, 64);
  within("scene_head_width", c.scene_encoder.head_width, 1, 256);
  within("scene_mlp", c.scene_encoder.mlp, 1, 8192);
  within("anchors", c.anchors, 1, 1024);
  within("diffusion_steps", c.diffusion_steps, 2, 10000);
  within("t_star", c.t_star, 0, c.diffusion_steps);
  within("guidance", c.guidance, 0, 100);
  within("joints_weight", c.joints_weight, 0, 1000);
  within("velocity_weight", c.velocity_weight, 0, 1000);
  within("feet_weight", c.feet_weight, 0, 1000);
  within("rest_turn", c.rest_turn, 0, 90);
  within("scene_dropout", c.scene_dropout, 0, 1);
}

}  // namespace inhabit::inbetween
