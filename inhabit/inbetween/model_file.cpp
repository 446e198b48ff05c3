#include "inhabit/inbetween/model_file.h"

#include "inhabit/error.h"
#include "inhabit/inbetween/residual.h"
#include "inhabit/nn/model_file.h"

namespace inhabit::inbetween {

SafeTensors model_header(const Networks& networks) {
  SafeTensors content = nn::model_content(kSystem, to_json(networks.config));
  if (networks.config.residual) {
    content.tensors["scale.residual"] = networks.residual_table;
  } else {
    content.tensors["scale.mean"] = networks.scale.mean;
    content.tensors["scale.deviation"] = networks.scale.deviation;
  }
  return content;
}

void save_networks(const std::string& path, const Networks& networks, bool half) {
  SafeTensors content = model_header(networks);
  nn::collect_parameters(*networks.network, "net.", content);
  if (networks.path) nn::collect_parameters(*networks.path, "path.", content);
  if (networks.feet) nn::collect_parameters(*networks.feet, "feet.", content);
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
    if (n.config.residual)
      n.residual_table = file.tensor("scale.residual", {kScaleRows, kResidualFeatures});
    else
      n.scale = {file.tensor("scale.mean", {kFeatureCount}), file.positive_tensor("scale.deviation", {kFeatureCount})};
  }
  n.network = file.network("net.", [&] { return Denoiser(n.config); });
  if (n.network.is_empty()) throw Error(path, "holds no network");
  n.path = file.network("path.", [] { return PathNet(); });
  n.feet = file.network("feet.", [&] { return foot_contact_net(n.config); });
  return n;
}

}  // namespace inhabit::inbetween
