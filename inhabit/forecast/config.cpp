#include "inhabit/forecast/config.h"

#include <algorithm>

#include "inhabit/error.h"
#include "inhabit/io/config_fields.h"

namespace inhabit::forecast {
namespace {

using nlohmann::json;

// Block lists are written as the released configuration writes them:
// abstraction [[channels, blocks, grid], [centres, radius, neighbours, [mlp...]]], propagation [[mlp...], [channels,
// blocks, grid]], with [] or null where there are no convolutions.

json convolution_json(const std::optional<PointVoxelSpec>& spec) {
  return spec ? json{spec->channels, spec->blocks, spec->grid} : json::array();
}

std::optional<PointVoxelSpec> convolution_from(const json& value) {
  if (value.is_null() || value.empty()) return std::nullopt;
  return PointVoxelSpec{value.at(0).get<int>(), value.at(1).get<int>(), value.at(2).get<int>()};
}

json abstraction_json(const std::vector<AbstractionSpec>& specs) {
  json list = json::array();
  for (const AbstractionSpec& spec : specs)
    list.push_back({convolution_json(spec.convolution), {spec.centres, spec.radius, spec.neighbours, spec.mlp}});
  return list;
}

std::vector<AbstractionSpec> abstraction_from(const json& list) {
  std::vector<AbstractionSpec> specs;
  for (const json& item : list) {
    const json& group = item.at(1);
    specs.push_back({convolution_from(item.at(0)), group.at(0).get<int>(), group.at(1).get<double>(),
                     group.at(2).get<int>(), group.at(3).get<std::vector<int>>()});
  }
  return specs;
}

json propagation_json(const std::vector<PropagationSpec>& specs) {
  json list = json::array();
  for (const PropagationSpec& spec : specs) list.push_back({spec.mlp, convolution_json(spec.convolution)});
  return list;
}

std::vector<PropagationSpec> propagation_from(const json& list) {
  std::vector<PropagationSpec> specs;
  for (const json& item : list) specs.push_back({item.at(0).get<std::vector<int>>(), convolution_from(item.at(1))});
  return specs;
}

constexpr auto fields = [](auto& config, const auto& visit) {
  visit("preset", config.preset);
  visit("rate", config.rate);
  visit("past", config.past);
  visit("future", config.future);
  visit("joints", config.joints);
  visit("root", config.root);
  visit("hips", config.hips);
  visit("sigma", config.sigma);
  visit("contact_threshold", config.inference.contact_threshold);
  visit("contact_coefficients", config.contact_coefficients);
  visit("root_coefficients", config.root_coefficients);
  visit("hidden", config.hidden);
  visit("points", config.inference.points);
  visit("radius", config.inference.radius);
  visit("decode_from_past", config.decode_from_past);
  visit("decoder", config.decoder);
  visit("articulated.width", config.articulated.width);
  visit("articulated.blocks", config.articulated.blocks);
  visit("articulated.stride", config.articulated.stride);
  visit("articulated.coefficients", config.articulated.coefficients);
  visit("articulated.root_continuation", config.articulated.root_continuation);
  visit("articulated.pose_continuation", config.articulated.pose_continuation);
  visit("articulated.gate", config.articulated.gate);
  visit("articulated.hypotheses", config.articulated.hypotheses);
  visit("training.contact_steps", config.training.contact_steps);
  visit("training.motion_steps", config.training.motion_steps);
  visit("training.hypotheses_steps", config.training.hypotheses_steps);
  visit("training.adapt_steps", config.training.adapt_steps);
  visit("training.contact_batch", config.training.contact_batch);
  visit("training.motion_batch", config.training.motion_batch);
  visit("training.contact_rate", config.training.contact_rate);
  visit("training.motion_rate", config.training.motion_rate);
  visit("training.stride", config.training.stride);
  visit("training.root_weight", config.training.root_weight);
  visit("training.pose_weight", config.training.pose_weight);
  visit("training.contact_weight", config.training.contact_weight);
  visit("training.velocity_weight", config.training.velocity_weight);
  visit("training.recorded", config.training.recorded);
  visit("training.mirror", config.training.mirror);
  visit("training.stature", config.training.stature);
  visit("training.time_warp", config.training.time_warp);
  visit("training.dropout", config.training.dropout);
  visit("training.warmup", config.training.schedule.warmup);
  visit("training.rate_floor", config.training.schedule.floor);
  visit("baselines.ltd_hidden", config.baselines.ltd_hidden);
  visit("baselines.ltd_blocks", config.baselines.ltd_blocks);
  visit("baselines.hisrep_query", config.baselines.hisrep_query);
  visit("baselines.hisrep_future", config.baselines.hisrep_future);
  visit("baselines.hisrep_hidden", config.baselines.hisrep_hidden);
  visit("baselines.hisrep_blocks", config.baselines.hisrep_blocks);
  visit("baselines.dmgnn_width", config.baselines.dmgnn_width);
  visit("baselines.slt_goal", config.baselines.slt_goal);
  visit("baselines.slt_path", config.baselines.slt_path);
  visit("baselines.slt_pose", config.baselines.slt_pose);
};

void check_convolution(const std::optional<PointVoxelSpec>& spec, const ConfigCheck& check) {
  if (!spec) return;
  check.within("convolution channels", spec->channels, 1, 8192);
  check.within("convolution blocks", spec->blocks, 1, 64);
  check.within("voxel grid", spec->grid, 2, 128);
}

void check_mlp(const std::vector<int>& mlp, const ConfigCheck& check) {
  check.within("MLP depth", static_cast<double>(mlp.size()), 1, 32);
  for (const int width : mlp) check.within("MLP width", width, 1, 8192);
}

}  // namespace

Config preset(const std::string& name) {
  Config config;
  config.preset = name;
  if (name == "paper") {
    config.abstraction = {{PointVoxelSpec{64, 2, 32}, 1024, 0.1, 32, {64, 128}},
                          {PointVoxelSpec{128, 2, 16}, 256, 0.2, 32, {128, 128}},
                          {PointVoxelSpec{128, 2, 8}, 64, 0.4, 32, {128, 256}},
                          {std::nullopt, 16, 0.8, 32, {256, 256, 512}}};
    config.propagation = {{{256, 256}, PointVoxelSpec{256, 1, 8}},
                          {{256, 256}, PointVoxelSpec{256, 1, 8}},
                          {{256, 128}, PointVoxelSpec{128, 2, 16}},
                          {{128, 128, 64}, PointVoxelSpec{64, 1, 32}}};
  } else if (name == "compact") {
    config.hips = {1, 2};
    config.inference.points = 1500;
    config.contact_coefficients = 12;
    config.training.contact_steps = 6500;  // two hours on two cores
    config.training.motion_steps = 10000;
    config.training.recorded = 0.5;
    config.training.mirror = true;
    config.decoder = "articulated";
    config.articulated.hypotheses = 5;
    config.training.contact_batch = 8;
    config.training.contact_rate = 1e-3;
    config.abstraction = {{PointVoxelSpec{32, 1, 16}, 256, 0.25, 16, {32, 64}},
                          {PointVoxelSpec{64, 1, 8}, 64, 0.5, 16, {64, 128}},
                          {std::nullopt, 16, 1.0, 16, {128, 256}}};
    config.propagation = {{{128, 128}, std::nullopt}, {{128, 64}, PointVoxelSpec{64, 1, 8}}, {{64, 64}, std::nullopt}};
  } else {
    throw Error("preset '" + name + "'", "unknown; there are paper and compact");
  }
  return config;
}

// The block lists are no fields, so that this and config_from_json() are not those of the other systems.
std::string to_json(const Config& config) {
  nlohmann::ordered_json root = fields_to_json(config, fields);
  if (config.decoder == "recurrent" && config.articulated == Config::Articulated{}) {
    root.erase("decoder");  // so that a configuration reads as those of files that are older than the choice
    root.erase("articulated");
  }
  root["abstraction"] = abstraction_json(config.abstraction);
  root["propagation"] = propagation_json(config.propagation);
  return root.dump();
}

Config config_from_json(const std::string& text, const std::string& subject) {
  const json root = config_object(text, subject);
  Config config;
  fields_from_json(root, subject, fields, config, {"abstraction", "propagation"});
  try {
    config.abstraction = abstraction_from(root.at("abstraction"));
    config.propagation = propagation_from(root.at("propagation"));
  } catch (const json::exception& e) {
    throw Error(subject, std::string("malformed forecast configuration: ") + e.what());
  }
  validate(config, subject);
  return config;
}

Config released_config(const std::map<std::string, std::string>& metadata, const std::string& subject) {
  Config config;
  config.preset = "released";
  config.decode_from_past = true;
  const auto text = [&](const char* key) {
    const auto found = metadata.find(key);
    if (found == metadata.end()) throw Error(subject, std::string("metadata lacks '") + key + "'");
    return found->second;
  };
  try {
    config.past = std::stoi(text("P"));
    config.future = std::stoi(text("T"));
    config.joints = std::stoi(text("J"));
    config.root = std::stoi(text("root"));
    config.inference.points = std::stoi(text("N"));
    config.sigma = std::stod(text("sigma"));
    config.inference.contact_threshold = std::stod(text("contact_threshold"));
    config.contact_coefficients = std::stoi(text("L"));
    config.root_coefficients = std::stoi(text("dct_n_root"));
    config.hidden = std::stoi(text("nh"));
    const json specs = json::parse(text("specs"));
    config.abstraction = abstraction_from(specs.at("sa_blocks"));
    config.propagation = propagation_from(specs.at("fp_blocks"));
  } catch (const json::exception& e) {
    throw Error(subject, std::string("malformed specs in the metadata: ") + e.what());
  } catch (const std::logic_error& e) {  // std::stoi, std::stod
    throw Error(subject, std::string("malformed number in the metadata: ") + e.what());
  }
  validate(config, subject);
  return config;
}

void set_fields(Config& c, const std::vector<std::string>& settings) { inhabit::set_fields(settings, fields, c); }

void validate(const Config& c, const std::string& subject) {
  const ConfigCheck check{subject};
  constexpr double kTiny = 1e-9;  // over 0
  check.within("rate", c.rate, kTiny, 1000);
  check.within("past", c.past, 1, 10000);
  check.within("future", c.future, 1, 10000);
  check.within("joints", c.joints, 1, 1000);
  check.within("root", c.root, 0, c.joints - 1);
  check.holds(c.hips.empty() || c.hips.size() == 2, "hips");
  for (const int hip : c.hips) check.within("hips", hip, 0, c.joints - 1);
  check.within("sigma", c.sigma, kTiny, 100);
  check.within("contact_threshold", c.inference.contact_threshold, kTiny, 1 - kTiny);
  check.within("contact_coefficients", c.contact_coefficients, 1, c.frames());
  check.within("root_coefficients", c.root_coefficients, 1, c.frames());
  check.within("hidden", c.hidden, 1, 8192);
  check.within("points", c.inference.points, 1, 10'000'000);
  check.within("radius", c.inference.radius, kTiny, 1000);
  const Config::Training& t = c.training;
  for (const auto& [name, steps] : {std::pair("training.contact_steps", t.contact_steps),
                                    {"training.motion_steps", t.motion_steps},
                                    {"training.hypotheses_steps", t.hypotheses_steps},
                                    {"training.adapt_steps", t.adapt_steps}})
    check.within(name, steps, 0, 100'000'000);
  for (const auto& [name, batch] : {std::pair("training.contact_batch", t.contact_batch),
                                    {"training.motion_batch", t.motion_batch},
                                    {"training.stride", t.stride}})
    check.within(name, batch, 1, 100'000);
  for (const auto& [name, weight] : {std::pair("training.contact_rate", t.contact_rate),
                                     {"training.motion_rate", t.motion_rate},
                                     {"training.root_weight", t.root_weight},
                                     {"training.pose_weight", t.pose_weight},
                                     {"training.contact_weight", t.contact_weight},
                                     {"training.velocity_weight", t.velocity_weight}})
    check.within(name, weight, 0, 1e6);
  check.within("training.recorded", t.recorded, 0, 1);
  check.within("training.stature", t.stature, 0, 0.5);
  check.within("training.time_warp", t.time_warp, 0, 1);
  check.within("training.dropout", t.dropout, 0, 0.9);
  check.holds(c.decoder == "recurrent" || c.decoder == "articulated", "decoder");
  if (c.decoder == "articulated") {
    const Config::Articulated& a = c.articulated;
    check.within("past", c.past, 2, 10000);
    check.within("articulated.width", a.width, 1, 8192);
    check.within("articulated.blocks", a.blocks, 1, 256);
    check.within("articulated.stride", a.stride, 1, std::min(c.past - 1, c.future));
    check.within("articulated.coefficients", a.coefficients, 1, c.future);
    check.within("articulated.root_continuation", a.root_continuation, kTiny, 100);
    check.within("articulated.pose_continuation", a.pose_continuation, kTiny, 100);
    check.within("articulated.gate", a.gate, kTiny, 100);
    check.within("articulated.hypotheses", a.hypotheses, 0, 1000);
  }
  check_schedule(check, t.schedule);
  check.within("baselines.ltd_hidden", c.baselines.ltd_hidden, 1, 4096);
  check.within("baselines.ltd_blocks", c.baselines.ltd_blocks, 1, 64);
  check.within("baselines.hisrep_query", c.baselines.hisrep_query, 2, 10000);
  check.within("baselines.hisrep_future", c.baselines.hisrep_future, 1, 10000);
  check.within("baselines.hisrep_hidden", c.baselines.hisrep_hidden, 1, 4096);
  check.within("baselines.hisrep_blocks", c.baselines.hisrep_blocks, 1, 64);
  check.within("baselines.dmgnn_width", c.baselines.dmgnn_width, 1, 512);
  check.within("baselines.slt_goal", c.baselines.slt_goal, 1, 4096);
  check.within("baselines.slt_path", c.baselines.slt_path, 1, 4096);
  check.within("baselines.slt_pose", c.baselines.slt_pose, 1, 4096);
  check.within("abstraction levels", static_cast<double>(c.abstraction.size()), 1, 16);
  check.holds(c.abstraction.size() == c.propagation.size(), "as many levels up as down");
  for (const AbstractionSpec& spec : c.abstraction) {
    check_convolution(spec.convolution, check);
    check.within("centres", spec.centres, 1, 1'000'000);
    check.within("neighbourhood radius", spec.radius, kTiny, 1000);
    check.within("neighbours", spec.neighbours, 1, 4096);
    check_mlp(spec.mlp, check);
  }
  for (const PropagationSpec& spec : c.propagation) {
    check_convolution(spec.convolution, check);
    check_mlp(spec.mlp, check);
  }
}

}  // namespace inhabit::forecast
