#include "inhabit/interact/model_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "inhabit/error.h"
#include "inhabit/io/config_fields.h"
#include "inhabit/nn/model_file.h"

namespace inhabit::interact {

using torch::Tensor;

namespace {

constexpr int64_t kLargest = 1'000'000;  // more numbers than any frame has

FeatureScale no_scale(int64_t size) { return {torch::zeros({size}), torch::ones({size})}; }

/// Sizes in a released file's metadata.
struct ReleasedSizes {
  const nn::ModelFile& file;

  const std::string& text(const char* key) const {
    const auto found = file.content.metadata.find(key);
    if (found == file.content.metadata.end()) throw Error(file.path, std::string("metadata lacks '") + key + "'");
    return found->second;
  }
  int number(const char* key) const {
    const nlohmann::json value = nlohmann::json::parse(text(key), nullptr, /*allow_exceptions=*/false);
    int size = 0;
    if (!take(value, size) || size < 1 || size > kLargest)
      throw Error(file.path, std::string("malformed number in the metadata: '") + key + "'");
    return size;
  }
  std::vector<int> list(const char* key) const {
    const nlohmann::json value = nlohmann::json::parse(text(key), nullptr, /*allow_exceptions=*/false);
    std::vector<int> sizes;
    if (!take(value, sizes)) throw Error(file.path, std::string("malformed list in the metadata: '") + key + "'");
    return sizes;
  }
  bool has(const std::string& tensor) const { return file.content.tensors.count(tensor) != 0; }
};

void read_released_pose(const ReleasedSizes& released, Networks& n) {
  Config& c = n.config;
  c.encoders = released.list("encoders");
  c.experts = released.number("experts");
  c.hidden = released.number("hidden");
  c.gating_hidden = released.number("gating_hidden");
  c.encoder_layers = 0;  // indices of a Sequential: dropout, linear, ELU
  while (released.has("encoder0." + std::to_string(3 * c.encoder_layers + 1) + ".weight")) ++c.encoder_layers;
  validate(c, released.file.path);
  PoseSizes s = pose_sizes(c);
  int64_t first = 0;
  s.inputs.clear();
  for (const char* key : {"start_goal", "start_environment", "start_interaction", "start_hand", "start_gating"}) {
    const int64_t end = released.number(key);
    if (end <= first) throw Error(released.file.path, std::string("'") + key + "' in the metadata is out of order");
    s.inputs.push_back(end - first);
    first = end;
  }
  s.gating = released.number("dim_gating");
  s.row = first + s.gating;
  s.outputs = released.number("outputs");
  n.pose = released.file.network("", [&] { return PoseNetwork(s); });
  n.input_scale = no_scale(s.row);
  n.output_scale = no_scale(s.outputs);
}

void read_released_control(const ReleasedSizes& released, Networks& n) {
  Config& c = n.config;
  const Tensor state = released.file.tensor("h0", {-1, 1, -1});
  c.joints = released.number("pose") / 3;
  c.future_keys = released.number("control") / 8 - 1;
  c.control_encoder = released.number("hidden");
  c.control_layers = static_cast<int>(state.size(0));
  c.control_hidden = static_cast<int>(state.size(2));
  validate(c, released.file.path);
  n.control = released.file.network("", [&] { return ControlNetwork(c); });
}

void read_released_contact(const ReleasedSizes& released, Networks& n) {
  Config& c = n.config;
  c.chair_grid = static_cast<int>(std::lround(std::cbrt(released.number("condition") / 4.0)));
  c.contact_hidden = released.number("hidden");
  c.contact_code = released.number("code");
  c.contact_z = released.number("z");
  validate(c, released.file.path);
  n.contact = released.file.network("", [&] { return ContactNetwork(c); });
}

/// Tensors PREFIXends and PREFIXpoints; empty where the file has none.
StayPoints stays_in(const nn::ModelFile& file, const std::string& prefix) {
  StayPoints out;
  const std::string name = prefix + "ends";
  const auto ends = file.content.tensors.find(name);
  if (ends == file.content.tensors.end()) return out;
  if (ends->second.dim() != 1 || ends->second.scalar_type() != torch::kInt64 || ends->second.size(0) == 0)
    throw Error(file.path, "'" + name + "' is no list of whole numbers");
  out.ends = ends->second.contiguous();
  out.points = file.tensor(prefix + "points", {-1, 15}).contiguous();
  int64_t before = 0;
  for (int64_t i = 0; i < out.size(); ++i) {
    const int64_t end = out.ends.data_ptr<int64_t>()[i];
    if (end <= before + 1 || end > out.points.size(0)) throw Error(file.path, "'" + name + "' are out of order");
    before = end;
  }
  return out;
}

Habits habits_in(const nn::ModelFile& file, const Config& config) {
  Habits out;
  if (!config.seated_habits) return out;
  out.seated = stays_in(file, "habits.");
  out.standing = stays_in(file, "habits.standing_");
  if (out.seated.size() == 0) return out;
  out.chairs = file.tensor("habits.chairs", {out.seated.size(), config.chair_size()});
  out.heights = file.tensor("habits.heights", {out.seated.size()});
  return out;
}

void put_stays(const StayPoints& stays, const std::string& prefix, SafeTensors& content) {
  if (stays.size() == 0) return;
  content.tensors[prefix + "ends"] = stays.ends;
  content.tensors[prefix + "points"] = stays.points;
}

/// True where the file was of a released network, which then is in `n`.
bool read_released(const nn::ModelFile& file, Networks& n) {
  const ReleasedSizes released{file};
  n.config.preset = "released";
  n.config.ego_rings = n.config.ego_layers = 9;
  if (released.has("predNN.expert_weights_fc0")) {
    read_released_pose(released, n);
  } else if (released.has("rnn.weight_ih_l0")) {
    read_released_control(released, n);
  } else if (released.has("encoder.cond_encoder1.0.weight")) {
    read_released_contact(released, n);
  } else {
    return false;
  }
  return true;
}

/// Calls visit(prefix, network) for each of the networks.
template <class AnyNetworks, class Visit>
void each_network(AnyNetworks& n, const Visit& visit) {
  visit("pose_net.", n.pose);
  visit("control_net.", n.control);
  visit("contact_net.", n.contact);
  visit("nsm_net.", n.nsm);
  visit("nsm_control_net.", n.nsm_control);
  visit("samp_net.", n.samp);
  visit("samp_control_net.", n.samp_control);
}

}  // namespace

bool holds(const Networks& n, Predictor predictor) {
  switch (predictor) {
    case Predictor::nsm:
      return !n.nsm.is_empty();
    case Predictor::nsm_control:
      return !n.nsm_control.is_empty();
    case Predictor::samp:
      return !n.samp.is_empty();
    case Predictor::samp_control:
      return !n.samp_control.is_empty();
    case Predictor::pose:
      break;
  }
  return !n.pose.is_empty();
}

SafeTensors model_content(const Networks& networks, const std::vector<std::string>& without) {
  SafeTensors content = nn::model_content(kSystem, to_json(networks.config));
  content.tensors["scale.input_mean"] = networks.input_scale.mean;
  content.tensors["scale.input_deviation"] = networks.input_scale.deviation;
  content.tensors["scale.output_mean"] = networks.output_scale.mean;
  content.tensors["scale.output_deviation"] = networks.output_scale.deviation;
  if (networks.habits.seated.size() > 0) {
    content.tensors["habits.chairs"] = networks.habits.chairs;
    content.tensors["habits.heights"] = networks.habits.heights;
  }
  put_stays(networks.habits.seated, "habits.", content);
  put_stays(networks.habits.standing, "habits.standing_", content);
  each_network(networks, [&](const std::string& prefix, const auto& network) {
    const bool wanted =
        std::none_of(without.begin(), without.end(), [&](const std::string& name) { return name + "_net." == prefix; });
    if (wanted && !network.is_empty()) nn::collect_parameters(*network, prefix, content);
  });
  return content;
}

void save_networks(const std::string& path, const Networks& networks, bool half) {
  write_safetensors(path, model_content(networks), half);
}

Networks load_networks(const std::string& path) {
  const nn::ModelFile file = nn::read_model_file(path);
  Networks n;
  if (file.system().empty() && read_released(file, n)) return n;
  n.config = config_from_json(file.config_of(kSystem), path);
  const Config& c = n.config;
  const PoseSizes sizes = pose_sizes(c);
  n.input_scale = {file.tensor("scale.input_mean", {sizes.row}),
                   file.positive_tensor("scale.input_deviation", {sizes.row})};
  n.output_scale = {file.tensor("scale.output_mean", {sizes.outputs}),
                    file.positive_tensor("scale.output_deviation", {sizes.outputs})};
  n.habits = habits_in(file, c);
  n.pose = file.network("pose_net.", [&] { return PoseNetwork(sizes); });
  n.control = file.network("control_net.", [&] { return ControlNetwork(c); });
  n.contact = file.network("contact_net.", [&] { return ContactNetwork(c); });
  n.nsm = file.network("nsm_net.", [&] { return PoseNetwork(nsm_sizes(c, /*contacts=*/false)); });
  n.nsm_control = file.network("nsm_control_net.", [&] { return PoseNetwork(nsm_sizes(c, /*contacts=*/true)); });
  n.samp = file.network("samp_net.", [&] { return SampNetwork(c, /*contacts=*/false); });
  n.samp_control = file.network("samp_control_net.", [&] { return SampNetwork(c, /*contacts=*/true); });
  bool any = false;
  each_network(n, [&](const char*, const auto& network) { any = any || !network.is_empty(); });
  if (!any) throw Error(path, "holds no network");
  return n;
}

}  // namespace inhabit::interact
