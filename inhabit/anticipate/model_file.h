#pragma once
#include <map>
#include <string>

#include "inhabit/anticipate/features.h"
#include "inhabit/anticipate/grammar_network.h"
#include "inhabit/anticipate/intention.h"
#include "inhabit/anticipate/motion_memory.h"
#include "inhabit/anticipate/network.h"
#include "inhabit/anticipate/released_networks.h"
#include "inhabit/anticipate/variational_networks.h"
#include "inhabit/body/skeleton.h"
#include "inhabit/io/safetensors.h"
#include "inhabit/nn/motion_attention.h"
#include "inhabit/nn/trajectory_graph.h"

namespace inhabit::anticipate {

/// A trained model and what it is compared with; a network that a file lacks is null.
struct Networks {
  Config config;                                         ///< what all of them were made with
  Skeleton skeleton;                                     ///< the bones that the poses were learned on
  FeatureScale scale;                                    ///< of the features of a frame (F)
  IntentionClusters clusters;                            ///< what frames were labelled by
  std::shared_ptr<const MotionMemory> memory;            ///< what futures go on from; null without config.memory
  IntentionNetwork intention{nullptr};                   ///< "intention_net." in the file
  PoseNetwork pose{nullptr};                             ///< "pose_net."
  ReleasedIntentionNetwork released_intention{nullptr};  ///< in their place where config.released is set
  ReleasedPoseNetwork released_pose{nullptr};            ///< likewise
  Seq2SeqNetwork seq2seq{nullptr};                       ///< "seq2seq_net."
  nn::TrajectoryGraph ltd{nullptr};                      ///< "ltd_net.", LTD
  nn::MotionAttention hisrep{nullptr};                   ///< "hisrep_net.", HisRep
  MotionVae vae{nullptr};                                ///< "vae_net."
  LatentSampler dlow{nullptr};                           ///< "dlow_net.", DLow; it draws for `vae`
  MixMatchNetwork mix_match{nullptr};                    ///< "mix_match_net.", Mix-and-Match
  GrammarNetwork grammar{nullptr};                       ///< "grammar_net.", the adversarial generative grammar

  /// Whether the networks that forecast intention and pose are there.
  bool forecasts() const {
    if (config.released) return !released_intention.is_empty() && !released_pose.is_empty();
    return !pose.is_empty() && (!config.intention || !intention.is_empty()) && (!config.memory || memory);
  }
};

/// A new network of the config's sizes.
nn::TrajectoryGraph make_ltd(const Config& config);
/// A new HisRep of the sizes in config.baselines.
nn::MotionAttention make_hisrep(const Config& config);

/// What files of this system say they are of.
inline constexpr const char* kSystem = "intention-anticipation";
/// Such a file without networks and clusters: what run_stages writes beside them.
SafeTensors model_header(const Config& config, const Skeleton& skeleton, const FeatureScale& scale);
/// The clusters as tensors of a file.
std::map<std::string, torch::Tensor> cluster_tensors(const IntentionClusters& clusters);

/// What a memory remembers, as tensors of a file.
std::map<std::string, torch::Tensor> memory_tensors(const std::vector<Remembered>& recordings);
/// The memory of these recordings, as the configuration has it. @param subject named where they are too short.
std::shared_ptr<const MotionMemory> make_memory(std::vector<Remembered> recordings, const IntentionClusters& clusters,
                                                const Config& config, const std::string& subject);

/// Writes whichever networks are there. @param half store weights in half precision.
void save_networks(const std::string& path, const Networks& networks, bool half = false);

/// Networks come in evaluation mode on the CPU. Throws Error naming the file where it is of another system, or a
/// parameter is missing, of another shape, or not finite.
Networks load_networks(const std::string& path);

}  // namespace inhabit::anticipate
