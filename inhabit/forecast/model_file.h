#pragma once
#include <string>

#include "inhabit/forecast/articulated_network.h"
#include "inhabit/forecast/dmgnn_network.h"
#include "inhabit/forecast/hypotheses.h"
#include "inhabit/forecast/network.h"
#include "inhabit/forecast/slt_network.h"
#include "inhabit/io/safetensors.h"
#include "inhabit/nn/motion_attention.h"
#include "inhabit/nn/trajectory_graph.h"

namespace inhabit::forecast {

/// Both stages of a forecasting model and its variants; a network that a file lacks is null.
struct Networks {
  Config config;                            ///< what all of them were made with
  ContactNetwork contact{nullptr};          ///< stage one, "contact_net." in the file
  MotionNetwork motion{nullptr};            ///< stage two, "motion_net."
  MotionNetwork no_contact{nullptr};        ///< stage two without contact points, "no_contact_net."
  ArticulatedNetwork articulated{nullptr};  ///< stage two where config.decoder is "articulated", "articulated_net."
  HypothesesNetwork hypotheses{nullptr};    ///< ways to go on beside the one of `articulated`, "hypotheses_net."
  nn::TrajectoryGraph ltd{nullptr};         ///< LTD, which knows nothing of the scene, "ltd_net."
  nn::MotionAttention hisrep{nullptr};      ///< HisRep, neither, "hisrep_net."
  DmgnnNetwork dmgnn{nullptr};              ///< DMGNN, neither, "dmgnn_net."
  SltNetwork slt{nullptr};                  ///< SLT*, which sees the scene, "slt_net."

  /// Whether there are a contact network and one that moves the person by what it predicts.
  bool complete() const { return !contact.is_empty() && !(motion.is_empty() && articulated.is_empty()); }
};

/// A new LTD network of the config's sizes: joints (B, P, 3 J) -> (B, T, 3 J).
nn::TrajectoryGraph make_ltd(const Config& config);

/// A new HisRep of the config's sizes, of 3 J coordinates. Throws Error where it needs more frames than the past has.
nn::MotionAttention make_hisrep(const Config& config);

/// What files of this system say they are of.
inline constexpr const char* kSystem = "contact-forecast";
/// Such a file without networks: what run_stages writes beside them.
SafeTensors model_header(const Config& config);

/// Writes whichever networks are there, with the config in the metadata. @param half store weights in half precision.
void save_networks(const std::string& path, const Networks& networks, bool half = false);

/// Reads a file written by save_networks(), or one with released parameter names and sizes in its metadata.
/// Networks come in evaluation mode on the CPU. Throws Error naming the file where it is of another system, or a
/// parameter is missing, of another shape, or not finite.
Networks load_networks(const std::string& path);

}  // namespace inhabit::forecast
