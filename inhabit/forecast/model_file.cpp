#include "inhabit/forecast/model_file.h"

#include "inhabit/error.h"
#include "inhabit/nn/model_file.h"

namespace inhabit::forecast {

nn::TrajectoryGraph make_ltd(const Config& c) {
  return nn::TrajectoryGraph(3 * c.joints, c.past, c.future, c.baselines.ltd_hidden, c.baselines.ltd_blocks);
}

nn::MotionAttention make_hisrep(const Config& c) {
  const Config::Baselines& b = c.baselines;
  if (b.hisrep_query + b.hisrep_future > c.past)
    throw Error("baselines.hisrep_query", "and hisrep_future are longer together than what is observed");
  return nn::MotionAttention(3 * c.joints, b.hisrep_query, b.hisrep_future, b.hisrep_hidden, b.hisrep_blocks);
}

SafeTensors model_header(const Config& config) { return nn::model_content(kSystem, to_json(config)); }

void save_networks(const std::string& path, const Networks& networks, bool half) {
  SafeTensors content = model_header(networks.config);
  if (!networks.contact.is_empty()) nn::collect_parameters(*networks.contact, "contact_net.", content);
  if (!networks.motion.is_empty()) nn::collect_parameters(*networks.motion, "motion_net.", content);
  if (!networks.no_contact.is_empty()) nn::collect_parameters(*networks.no_contact, "no_contact_net.", content);
  if (!networks.articulated.is_empty()) nn::collect_parameters(*networks.articulated, "articulated_net.", content);
  if (!networks.hypotheses.is_empty()) nn::collect_parameters(*networks.hypotheses, "hypotheses_net.", content);
  if (!networks.ltd.is_empty()) nn::collect_parameters(*networks.ltd, "ltd_net.", content);
  if (!networks.hisrep.is_empty()) nn::collect_parameters(*networks.hisrep, "hisrep_net.", content);
  if (!networks.dmgnn.is_empty()) nn::collect_parameters(*networks.dmgnn, "dmgnn_net.", content);
  if (!networks.slt.is_empty()) nn::collect_parameters(*networks.slt, "slt_net.", content);
  write_safetensors(path, content, half);
}

Networks load_networks(const std::string& path) {
  const nn::ModelFile file = nn::read_model_file(path);
  const bool released = file.system().empty() && (nn::has_parameters(file.content, "contact_net.") ||
                                                  nn::has_parameters(file.content, "motion_net."));
  Networks n;
  n.config = released ? released_config(file.content.metadata, path) : config_from_json(file.config_of(kSystem), path);
  n.contact = file.network("contact_net.", [&] { return ContactNetwork(n.config); });
  n.motion = file.network("motion_net.", [&] { return MotionNetwork(n.config); });
  n.no_contact = file.network("no_contact_net.", [&] { return MotionNetwork(n.config, /*with_contact=*/false); });
  for (const char* prefix : {"articulated_net.", "hypotheses_net."})
    if (nn::has_parameters(file.content, prefix) && n.config.decoder != "articulated")
      throw Error(path, std::string("holds '") + prefix + "', which its configuration has no place for");
  if (nn::has_parameters(file.content, "hypotheses_net.") && n.config.articulated.hypotheses == 0)
    throw Error(path, "holds hypotheses, of which its configuration has none");
  n.articulated = file.network("articulated_net.", [&] { return ArticulatedNetwork(n.config); });
  n.hypotheses = file.network("hypotheses_net.", [&] { return HypothesesNetwork(n.config); });
  n.ltd = file.network("ltd_net.", [&] { return make_ltd(n.config); });
  n.hisrep = file.network("hisrep_net.", [&] { return make_hisrep(n.config); });
  n.dmgnn = file.network("dmgnn_net.", [&] { return DmgnnNetwork(n.config); });
  n.slt = file.network("slt_net.", [&] { return SltNetwork(n.config); });
  if (n.contact.is_empty() && n.motion.is_empty() && n.no_contact.is_empty() && n.articulated.is_empty() &&
      n.ltd.is_empty() && n.hisrep.is_empty() && n.dmgnn.is_empty() && n.slt.is_empty())
    throw Error(path, "holds no network");
  return n;
}

}  // namespace inhabit::forecast
