#include "inhabit/forecast/model_file.h"

#include "inhabit/error.h"
#include "inhabit/io/safetensors.h"
#include "inhabit/nn/parameters.h"

namespace inhabit::forecast {
namespace {

constexpr const char* kSystem = "contact-forecast";

}  // namespace

nn::TrajectoryGraph make_trajectory_network(const Config& c) {
  return nn::TrajectoryGraph(3 * c.joints, c.past, c.future, c.trajectory_hidden, c.trajectory_blocks);
}

void save_networks(const std::string& path, const Networks& networks, bool half) {
  SafeTensors content;
  content.metadata = {{"system", kSystem}, {"config", to_json(networks.config)}};
  if (!networks.contact.is_empty()) nn::collect_parameters(*networks.contact, "contact_net.", content);
  if (!networks.motion.is_empty()) nn::collect_parameters(*networks.motion, "motion_net.", content);
  if (!networks.no_contact.is_empty()) nn::collect_parameters(*networks.no_contact, "no_contact_net.", content);
  if (!networks.trajectory.is_empty()) nn::collect_parameters(*networks.trajectory, "trajectory_net.", content);
  write_safetensors(path, content, half);
}

Networks load_networks(const std::string& path) {
  const SafeTensors content = read_safetensors(path);
  const auto system = content.metadata.find("system");
  Networks networks;
  if (system != content.metadata.end()) {
    if (system->second != kSystem)
      throw Error(path, "is a model of '" + system->second.substr(0, 60) + "', not of " + kSystem);
    const auto config = content.metadata.find("config");
    if (config == content.metadata.end()) throw Error(path, "metadata lacks the configuration");
    networks.config = config_from_json(config->second, path);
  } else if (nn::has_parameters(content, "contact_net.") || nn::has_parameters(content, "motion_net.")) {
    networks.config = released_config(content.metadata, path);
  } else {
    throw Error(path, std::string("is not a model of ") + kSystem);
  }
  if (nn::has_parameters(content, "contact_net.")) {
    networks.contact = ContactNetwork(networks.config);
    nn::load_parameters(*networks.contact, "contact_net.", content, path);
  }
  if (nn::has_parameters(content, "motion_net.")) {
    networks.motion = MotionNetwork(networks.config);
    nn::load_parameters(*networks.motion, "motion_net.", content, path);
  }
  if (nn::has_parameters(content, "no_contact_net.")) {
    networks.no_contact = MotionNetwork(networks.config, false);
    nn::load_parameters(*networks.no_contact, "no_contact_net.", content, path);
  }
  if (nn::has_parameters(content, "trajectory_net.")) {
    networks.trajectory = make_trajectory_network(networks.config);
    nn::load_parameters(*networks.trajectory, "trajectory_net.", content, path);
  }
  if (networks.contact.is_empty() && networks.motion.is_empty() && networks.no_contact.is_empty() &&
      networks.trajectory.is_empty())
    throw Error(path, "holds no network");
  return networks;
}

}  // namespace inhabit::forecast
