#include "inhabit/forecast/config.h"

#include <cmath>

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
  visit("contact_threshold", config.contact_threshold);
  visit("contact_coefficients", config.contact_coefficients);
  visit("root_coefficients", config.root_coefficients);
  visit("hidden", config.hidden);
  visit("points", config.points);
  visit("radius", config.radius);
  visit("root_weight", config.root_weight);
  visit("pose_weight", config.pose_weight);
  visit("contact_weight", config.contact_weight);
  visit("decode_from_past", config.decode_from_past);
  visit("trajectory_hidden", config.trajectory_hidden);
  visit("trajectory_blocks", config.trajectory_blocks);
};

void check(bool good, const std::string& subject, const std::string& reason) {
  if (!good) throw Error(subject, "impossible configuration: " + reason);
}

bool within(int value, int lowest, int highest) { return value >= lowest && value <= highest; }

bool positive(double value) { return std::isfinite(value) && value > 0; }

void check_convolution(const std::optional<PointVoxelSpec>& spec, const std::string& subject) {
  if (!spec) return;
  check(within(spec->channels, 1, 8192), subject, "convolution channels");
  check(within(spec->blocks, 1, 64), subject, "convolution blocks");
  check(within(spec->grid, 2, 128), subject, "voxel grid");
}

void check_mlp(const std::vector<int>& mlp, const std::string& subject) {
  check(!mlp.empty() && mlp.size() <= 32, subject, "MLP depth");
  for (const int width : mlp) check(within(width, 1, 8192), subject, "MLP width");
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
    config.points = 1500;
    config.contact_coefficients = 12;
    config.abstraction = {{PointVoxelSpec{32, 1, 16}, 256, 0.25, 16, {32, 64}},
                          {PointVoxelSpec{64, 1, 8}, 64, 0.5, 16, {64, 128}},
                          {std::nullopt, 16, 1.0, 16, {128, 256}}};
    config.propagation = {{{128, 128}, std::nullopt}, {{128, 64}, PointVoxelSpec{64, 1, 8}}, {{64, 64}, std::nullopt}};
  } else {
    throw Error("preset '" + name + "'", "unknown; there are paper and compact");
  }
  return config;
}

std::string to_json(const Config& config) {
  nlohmann::ordered_json root = fields_to_json(config, fields);
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
    config.points = std::stoi(text("N"));
    config.sigma = std::stod(text("sigma"));
    config.contact_threshold = std::stod(text("contact_threshold"));
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

void validate(const Config& config, const std::string& subject) {
  check(positive(config.rate) && config.rate <= 1000, subject, "rate");
  check(within(config.past, 1, 10000), subject, "past frames");
  check(within(config.future, 1, 10000), subject, "future frames");
  check(within(config.joints, 1, 1000), subject, "joints");
  check(within(config.root, 0, config.joints - 1), subject, "root joint");
  check(config.hips.empty() || config.hips.size() == 2, subject, "hips");
  for (const int hip : config.hips) check(within(hip, 0, config.joints - 1), subject, "hips");
  check(positive(config.sigma) && config.sigma <= 100, subject, "sigma");
  check(positive(config.contact_threshold) && config.contact_threshold < 1, subject, "contact threshold");
  check(within(config.contact_coefficients, 1, config.frames()), subject, "contact coefficients");
  check(within(config.root_coefficients, 1, config.frames()), subject, "root coefficients");
  check(within(config.hidden, 1, 8192), subject, "hidden width");
  check(within(config.points, 1, 10'000'000), subject, "scene points");
  check(positive(config.radius) && config.radius <= 1000, subject, "radius");
  for (const double weight : {config.root_weight, config.pose_weight, config.contact_weight})
    check(std::isfinite(weight) && weight >= 0, subject, "loss weights");
  check(within(config.trajectory_hidden, 1, 4096), subject, "trajectory width");
  check(within(config.trajectory_blocks, 1, 64), subject, "trajectory blocks");
  check(!config.abstraction.empty() && config.abstraction.size() <= 16, subject, "abstraction levels");
  check(config.abstraction.size() == config.propagation.size(), subject, "as many levels up as down");
  for (const AbstractionSpec& spec : config.abstraction) {
    check_convolution(spec.convolution, subject);
    check(within(spec.centres, 1, 1'000'000), subject, "centres");
    check(positive(spec.radius) && spec.radius <= 1000, subject, "neighbourhood radius");
    check(within(spec.neighbours, 1, 4096), subject, "neighbours");
    check_mlp(spec.mlp, subject);
  }
  for (const PropagationSpec& spec : config.propagation) {
    check_convolution(spec.convolution, subject);
    check_mlp(spec.mlp, subject);
  }
}

}  // namespace inhabit::forecast
