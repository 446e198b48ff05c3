#include "inhabit/inbetween/model_file.h"

#include "inhabit/error.h"
#include "inhabit/nn/model_file.h"

namespace inhabit::inbetween {

SafeTensors model_header(const Config& config, const FeatureScale& scale) {
  SafeTensors content = nn::model_content(kSystem, to_json(config));
  content.tensors["scale.mean"] = scale.mean;
  content.tensors["scale.deviation"] = scale.deviation;
  return content;
}

void save_networks(const std::string& path, const Networks& networks, bool half) {
  SafeTensors content = model_header(networks.config, networks.scale);
  nn::collect_parameters(*networks.network, "net.", content);
  write_safetensors(path, content, half);
}

Networks load_networks(const std::string& path) {
  const nn::ModelFile file = nn::read_model_file(path);
  Networks n;
  if (file.system().empty() && nn::has_parameters(file.content, "net.unet.")) {
    n.config = released_config(file.content.metadata, path);
    n.scale = {torch::zeros({kFeatureCount}), torch::ones({kFeatureCount})};
  } else {
    n.config = config_from_json(file.config_of(kSystem), path);
    n.scale = {file.tensor("scale.mean", {kFeatureCount}), file.positive_tensor("scale.deviation", {kFeatureCount})};
  }
  n.network = file.network("net.", [&] { return Denoiser(n.config); });
  if (n.network.is_empty()) throw Error(path, "holds no network");
  return n;
}

}  // namespace inhabit::inbetween
