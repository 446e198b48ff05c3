#include "inhabit/inbetween/model_file.h"

#include "inhabit/error.h"
#include "inhabit/io/safetensors.h"
#include "inhabit/nn/parameters.h"

namespace inhabit::inbetween {
namespace {

constexpr const char* kSystem = "scene-inbetweening";

torch::Tensor scale_of(const SafeTensors& content, const std::string& name, const std::string& path) {
  const auto found = content.tensors.find(name);
  if (found == content.tensors.end()) throw Error(path, "lacks " + name);
  const torch::Tensor t = found->second.to(torch::kFloat32);
  if (t.dim() != 1 || t.size(0) != kFeatureCount) throw Error(path, name + " has the wrong shape");
  if (!t.isfinite().all().item<bool>()) throw Error(path, name + " is not finite");
  return t;
}

}  // namespace

void save_networks(const std::string& path, const Networks& networks, bool half) {
  SafeTensors content;
  content.metadata = {{"system", kSystem}, {"config", to_json(networks.config)}};
  content.tensors["scale.mean"] = networks.mean;
  content.tensors["scale.deviation"] = networks.deviation;
  nn::collect_parameters(*networks.network, "net.", content);
  write_safetensors(path, content, half);
}

Networks load_networks(const std::string& path) {
  const SafeTensors content = read_safetensors(path);
  Networks networks;
  const auto system = content.metadata.find("system"), config = content.metadata.find("config");
  if (system != content.metadata.end() && system->second == kSystem) {
    if (config == content.metadata.end()) throw Error(path, "metadata lacks the configuration");
    networks.config = config_from_json(config->second, path);
    networks.mean = scale_of(content, "scale.mean", path);
    networks.deviation = scale_of(content, "scale.deviation", path);
    if ((networks.deviation <= 0).any().item<bool>()) throw Error(path, "scale.deviation is not positive");
  } else if (system == content.metadata.end() && nn::has_parameters(content, "net.unet.")) {
    networks.config = released_config(content.metadata, path);
    networks.mean = torch::zeros({kFeatureCount});
    networks.deviation = torch::ones({kFeatureCount});
  } else {
    throw Error(path, std::string("is not a model of ") + kSystem);
  }
  networks.network = Denoiser(networks.config);
  nn::load_parameters(*networks.network, "net.", content, path);
  return networks;
}

}  // namespace inhabit::inbetween
