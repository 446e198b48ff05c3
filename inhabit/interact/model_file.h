#pragma once
#include <string>

#include "inhabit/interact/contact_network.h"
#include "inhabit/interact/control_network.h"
#include "inhabit/interact/habits.h"
#include "inhabit/interact/pose_network.h"
#include "inhabit/interact/predictor.h"
#include "inhabit/interact/samp_network.h"
#include "inhabit/io/safetensors.h"
#include "inhabit/nn/feature_scale.h"

namespace inhabit::interact {

/// A trained model and what it is compared with; a network that a file lacks is null.
struct Networks {
  Config config;                      ///< what all of them were made with
  FeatureScale input_scale;           ///< (4344 or 4362) of PoseNet's rows
  FeatureScale output_scale;          ///< (536) of what comes out
  Habits habits;                      ///< "habits."; empty without Config::seated_habits
  PoseNetwork pose{nullptr};          ///< "pose_net." in the file
  ControlNetwork control{nullptr};    ///< "control_net.", in metres and phases as they are
  ContactNetwork contact{nullptr};    ///< "contact_net.", in metres
  PoseNetwork nsm{nullptr};           ///< "nsm_net."
  PoseNetwork nsm_control{nullptr};   ///< "nsm_control_net.", contacts among the goals
  SampNetwork samp{nullptr};          ///< "samp_net."
  SampNetwork samp_control{nullptr};  ///< "samp_control_net."
};

/// True where the network of a predictor is there.
bool holds(const Networks& networks, Predictor predictor);

/// What files of this system say they are of.
inline constexpr const char* kSystem = "chair-interaction";
/// Such a file with whichever networks are there, but those that `without` names ("pose", "control", ...).
SafeTensors model_content(const Networks& networks, const std::vector<std::string>& without = {});

/// Writes whichever networks are there. @param half store weights in half precision.
void save_networks(const std::string& path, const Networks& networks, bool half = false);

/// Networks come in evaluation mode on the CPU. Files with one released network are read too (parameters without a
/// prefix, sizes in the metadata); they tell no scale, so that rows stay as they are (mean 0, deviation 1). Throws
/// Error naming the file where it is of another system, or a parameter is missing, of another shape, or not finite.
Networks load_networks(const std::string& path);

}  // namespace inhabit::interact
