#include "inhabit/anticipate/model_file.h"

#include "inhabit/anticipate/released_labels.h"
#include "inhabit/error.h"
#include "inhabit/nn/model_file.h"

namespace inhabit::anticipate {

using torch::Tensor;

nn::TrajectoryGraph make_ltd(const Config& c) {
  const Config::Baselines& b = c.baselines;
  return nn::TrajectoryGraph(kFeatureCount, b.ltd_past, b.ltd_future, b.ltd_hidden, b.ltd_blocks);
}

nn::MotionAttention make_hisrep(const Config& c) {
  const Config::Baselines& b = c.baselines;
  return nn::MotionAttention(kFeatureCount, b.hisrep_query, b.hisrep_future, b.hisrep_hidden, b.hisrep_blocks);
}

SafeTensors model_header(const Config& config, const Skeleton& skeleton, const FeatureScale& scale) {
  SafeTensors content = nn::model_content(kSystem, to_json(config));
  content.tensors["skeleton.offsets"] = skeleton.offsets;
  content.tensors["scale.mean"] = scale.mean;
  content.tensors["scale.deviation"] = scale.deviation;
  return content;
}

std::map<std::string, torch::Tensor> cluster_tensors(const IntentionClusters& clusters) {
  if (clusters.codes.defined()) {
    SafeTensors encoder;
    nn::collect_parameters(*clusters.encoder, "label_net.", encoder);
    encoder.tensors["clusters.codes"] = clusters.codes;
    return std::move(encoder.tensors);
  }
  std::map<std::string, torch::Tensor> out = {{"clusters.poses", clusters.poses}};
  if (clusters.labels.defined()) out["clusters.labels"] = clusters.labels;
  return out;
}

std::map<std::string, Tensor> memory_tensors(const std::vector<Remembered>& recordings) {
  std::vector<Tensor> features, typical;
  std::vector<int64_t> frames, validation;
  for (const Remembered& r : recordings) {
    features.push_back((r.features / kMemoryUnit).round().to(torch::kInt16));
    typical.push_back(r.typical);
    frames.push_back(r.features.size(0));
    validation.push_back(r.validation ? 1 : 0);
  }
  return {{"memory.features", torch::cat(features)},
          {"memory.typical", torch::cat(typical)},
          {"memory.frames", torch::tensor(frames)},
          {"memory.validation", torch::tensor(validation)}};
}

std::shared_ptr<const MotionMemory> make_memory(std::vector<Remembered> recordings, const IntentionClusters& clusters,
                                                const Config& config, const std::string& subject) {
  const Config::Inference& by = config.inference;
  return std::make_shared<const MotionMemory>(std::move(recordings), clusters,
                                              MotionMemory::Choice{config.kappa, by.memory_distance, by.memory_typical,
                                                                   by.memory_within, by.memory_stay, by.memory_warp},
                                              subject);
}

namespace {

std::vector<Remembered> remembered(const nn::ModelFile& file) {
  const auto integers = [&](const char* name, torch::ScalarType type, int64_t dimensions) {
    const auto found = file.content.tensors.find(name);
    if (found == file.content.tensors.end() || found->second.scalar_type() != type || found->second.dim() != dimensions)
      throw Error(file.path, std::string("lacks the tensor ") + name + " of its memory");
    return found->second;
  };
  const Tensor features = integers("memory.features", torch::kInt16, 2),
               frames = integers("memory.frames", torch::kInt64, 1),
               validation = integers("memory.validation", torch::kInt64, 1);
  if (validation.size(0) != frames.size(0)) throw Error(file.path, "memory.validation is not of each recording");
  const Tensor typical = file.tensor("memory.typical", {features.size(0)});
  std::vector<Remembered> out;
  int64_t first = 0;
  for (int64_t i = 0; i < frames.size(0); ++i) {
    const int64_t count = frames[i].item<int64_t>();
    if (features.size(1) != kFeatureCount || count < 1 || count > features.size(0) - first)
      throw Error(file.path, "has a memory whose recordings are not as long as it says");
    out.push_back({features.slice(0, first, first + count).to(torch::kFloat32) * kMemoryUnit,
                   typical.slice(0, first, first + count), validation[i].item<int64_t>() != 0});
    first += count;
  }
  if (first != features.size(0)) throw Error(file.path, "has a memory with frames of no recording");
  return out;
}

}  // namespace

void save_networks(const std::string& path, const Networks& networks, bool half) {
  SafeTensors content = model_header(networks.config, networks.skeleton, networks.scale);
  if (networks.clusters.poses.defined() || networks.clusters.codes.defined())
    content.tensors.merge(cluster_tensors(networks.clusters));
  if (networks.memory) content.tensors.merge(memory_tensors(networks.memory->recordings()));
  if (!networks.intention.is_empty()) nn::collect_parameters(*networks.intention, "intention_net.", content);
  if (!networks.pose.is_empty()) nn::collect_parameters(*networks.pose, "pose_net.", content);
  if (!networks.released_intention.is_empty())
    nn::collect_parameters(*networks.released_intention, "intention_net.", content);
  if (!networks.released_pose.is_empty()) nn::collect_parameters(*networks.released_pose, "pose_net.", content);
  if (!networks.seq2seq.is_empty()) nn::collect_parameters(*networks.seq2seq, "seq2seq_net.", content);
  if (!networks.ltd.is_empty()) nn::collect_parameters(*networks.ltd, "ltd_net.", content);
  if (!networks.hisrep.is_empty()) nn::collect_parameters(*networks.hisrep, "hisrep_net.", content);
  if (!networks.vae.is_empty()) nn::collect_parameters(*networks.vae, "vae_net.", content);
  if (!networks.dlow.is_empty()) nn::collect_parameters(*networks.dlow, "dlow_net.", content);
  if (!networks.mix_match.is_empty()) nn::collect_parameters(*networks.mix_match, "mix_match_net.", content);
  if (!networks.grammar.is_empty()) nn::collect_parameters(*networks.grammar, "grammar_net.", content);
  write_safetensors(path, content, half);
}

Networks load_networks(const std::string& path) {
  const nn::ModelFile file = nn::read_model_file(path);
  Networks n;
  n.config = config_from_json(file.config_of(kSystem), path);
  n.skeleton = {standard_joint_names(), standard_parents(), file.tensor("skeleton.offsets", {kStandardJoints, 3})};
  n.scale = {file.tensor("scale.mean", {kFeatureCount}), file.positive_tensor("scale.deviation", {kFeatureCount})};
  if (n.config.released) {
    n.released_intention =
        file.network("intention_net.", [&] { return ReleasedIntentionNetwork(n.config, kFeatureCount); });
    n.released_pose = file.network("pose_net.", [&] { return ReleasedPoseNetwork(n.config, kFeatureCount); });
  } else {
    n.intention = file.network("intention_net.", [&] { return IntentionNetwork(n.config); });
    n.pose = file.network("pose_net.", [&] { return PoseNetwork(n.config); });
  }
  n.seq2seq = file.network("seq2seq_net.", [&] { return Seq2SeqNetwork(n.config); });
  n.ltd = file.network("ltd_net.", [&] { return make_ltd(n.config); });
  n.hisrep = file.network("hisrep_net.", [&] { return make_hisrep(n.config); });
  if (!n.hisrep.is_empty() && n.hisrep->query + n.hisrep->future > n.config.observed)
    throw Error(path, "has a HisRep that needs more frames than are observed");
  n.vae = file.network("vae_net.", [&] { return MotionVae(n.config); });
  n.dlow = file.network("dlow_net.", [&] { return LatentSampler(n.config); });
  n.mix_match = file.network("mix_match_net.", [&] { return MixMatchNetwork(n.config); });
  n.grammar = file.network("grammar_net.", [&] { return GrammarNetwork(n.config); });
  if (!n.dlow.is_empty() && n.vae.is_empty()) throw Error(path, "has a DLow without the VAE that it draws for");
  if (n.intention.is_empty() && n.pose.is_empty() && n.released_intention.is_empty() && n.released_pose.is_empty() &&
      n.seq2seq.is_empty() && n.ltd.is_empty() && n.hisrep.is_empty() && n.vae.is_empty() && n.mix_match.is_empty() &&
      n.grammar.is_empty())
    throw Error(path, "holds no network");
  if (!n.released_pose.is_empty()) {
    n.clusters.codes = file.tensor("clusters.codes", {n.config.labels, kLabelCode});
    const auto encoder = file.network("label_net.", [] { return LabelAutoencoder(kLabelHidden, kLabelCode); });
    if (!encoder.is_empty()) n.clusters.encoder = encoder.ptr();
    if (!n.clusters.encoder) throw Error(path, "lacks the autoencoder of its labels");
  }
  if (!n.pose.is_empty()) {
    n.clusters.poses = file.tensor("clusters.poses", {-1, kPoseFeatures});
    if (n.config.naive_clusters && n.clusters.poses.size(0) != n.config.labels)
      throw Error(path, "clusters.poses are not as many as its labels");
    if (!n.config.naive_clusters)
      n.clusters.labels = file.tensor("clusters.labels", {n.config.labels, 2 * n.clusters.poses.size(1)});
    if (n.config.memory) n.memory = make_memory(remembered(file), n.clusters, n.config, path);
  }
  return n;
}

}  // namespace inhabit::anticipate
