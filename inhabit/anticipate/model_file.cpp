#include "inhabit/anticipate/model_file.h"

#include "inhabit/error.h"
#include "inhabit/io/safetensors.h"
#include "inhabit/nn/parameters.h"

namespace inhabit::anticipate {
namespace {

constexpr const char* kSystem = "intention-anticipation";

/// A float32 tensor of `shape`; -1 stands for any size over 0.
torch::Tensor required(const SafeTensors& content, const std::string& name, const std::vector<int64_t>& shape,
                       const std::string& path) {
  const auto found = content.tensors.find(name);
  if (found == content.tensors.end()) throw Error(path, "lacks " + name);
  const torch::Tensor t = found->second.to(torch::kFloat32);
  bool fits = t.dim() == static_cast<int64_t>(shape.size());
  for (size_t i = 0; fits && i < shape.size(); ++i)
    fits = shape[i] < 0 ? t.size(static_cast<int64_t>(i)) > 0 : t.size(static_cast<int64_t>(i)) == shape[i];
  if (!fits) throw Error(path, name + " has the wrong shape");
  if (!t.isfinite().all().item<bool>()) throw Error(path, name + " is not finite");
  return t;
}

template <class Network>
void load_network(Network& network, const Network& fresh, const std::string& prefix, const SafeTensors& content,
                  const std::string& path) {
  network = fresh;
  nn::load_parameters(*network, prefix, content, path);
}

}  // namespace

nn::TrajectoryGraph make_trajectory_network(const Config& c) {
  return nn::TrajectoryGraph(kFeatureCount, c.ltd_past, c.ltd_future, c.ltd_hidden, c.ltd_blocks);
}

void save_networks(const std::string& path, const Networks& networks, bool half) {
  SafeTensors content;
  content.metadata = {{"system", kSystem}, {"config", to_json(networks.config)}};
  content.tensors["skeleton.offsets"] = networks.skeleton.offsets;
  content.tensors["scale.mean"] = networks.scale.mean;
  content.tensors["scale.deviation"] = networks.scale.deviation;
  content.tensors["clusters.poses"] = networks.clusters.poses;
  if (networks.clusters.labels.defined()) content.tensors["clusters.labels"] = networks.clusters.labels;
  if (!networks.intention.is_empty()) nn::collect_parameters(*networks.intention, "intention_net.", content);
  if (!networks.pose.is_empty()) nn::collect_parameters(*networks.pose, "pose_net.", content);
  if (!networks.seq2seq.is_empty()) nn::collect_parameters(*networks.seq2seq, "seq2seq_net.", content);
  if (!networks.trajectory.is_empty()) nn::collect_parameters(*networks.trajectory, "trajectory_net.", content);
  write_safetensors(path, content, half);
}

Networks load_networks(const std::string& path) {
  const SafeTensors content = read_safetensors(path);
  const auto system = content.metadata.find("system"), config = content.metadata.find("config");
  if (system == content.metadata.end() || system->second != kSystem)
    throw Error(path, std::string("is not a model of ") + kSystem);
  if (config == content.metadata.end()) throw Error(path, "metadata lacks the configuration");
  Networks n;
  n.config = config_from_json(config->second, path);
  n.skeleton = {standard_joint_names(), standard_parents(),
                required(content, "skeleton.offsets", {kStandardJoints, 3}, path)};
  n.scale = {required(content, "scale.mean", {kFeatureCount}, path),
             required(content, "scale.deviation", {kFeatureCount}, path)};
  if ((n.scale.deviation <= 0).any().item<bool>()) throw Error(path, "scale.deviation is not positive");
  n.clusters.poses = required(content, "clusters.poses", {-1, kPoseFeatures}, path);
  if (!n.config.naive_clusters)
    n.clusters.labels = required(content, "clusters.labels", {n.config.labels, 2 * n.clusters.poses.size(1)}, path);
  if (nn::has_parameters(content, "intention_net."))
    load_network(n.intention, IntentionNetwork(n.config), "intention_net.", content, path);
  if (nn::has_parameters(content, "pose_net.")) load_network(n.pose, PoseNetwork(n.config), "pose_net.", content, path);
  if (nn::has_parameters(content, "seq2seq_net."))
    load_network(n.seq2seq, Seq2SeqNetwork(n.config), "seq2seq_net.", content, path);
  if (nn::has_parameters(content, "trajectory_net."))
    load_network(n.trajectory, make_trajectory_network(n.config), "trajectory_net.", content, path);
  if (n.intention.is_empty() && n.pose.is_empty() && n.seq2seq.is_empty() && n.trajectory.is_empty())
    throw Error(path, "holds no network");
  return n;
}

}  // namespace inhabit::anticipate
