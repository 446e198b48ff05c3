#pragma once
#include <string>

#include "inhabit/inbetween/foot_contact_net.h"
#include "inhabit/inbetween/network.h"
#include "inhabit/inbetween/path_net.h"
#include "inhabit/io/safetensors.h"
#include "inhabit/nn/feature_scale.h"

namespace inhabit::inbetween {

/// A trained denoiser, the scale of its features, PathNet and FootContactNet.
struct Networks {
  Config config;                 ///< sizes and settings that the denoiser was made with
  Denoiser network{nullptr};     ///< "net." in the file
  FeatureScale scale;            ///< (201)
  torch::Tensor residual_table;  ///< (61, 135) of residual motion (residual.h) instead
  PathNet path{nullptr};         ///< "path." in the file, of residual motion; may be empty: detours are searched for
  FootContactNet feet{nullptr};  ///< "feet." in the file, of residual motion; may be empty: contacts are found in the
                                 ///< motion
};

/// The system's name in its files.
inline constexpr const char* kSystem = "scene-inbetweening";
/// Such a file without the network: what run_stages writes beside it.
SafeTensors model_header(const Networks& networks);

/// @param half store weights in half precision.
void save_networks(const std::string& path, const Networks& networks, bool half = false);

/// The network comes in evaluation mode on the CPU. Files with released weights are read too; they tell no scale, so
/// that their features stay as they are (mean 0, deviation 1). Throws Error naming the file where it is of another
/// system, or a parameter is missing, of another shape, or not finite.
Networks load_networks(const std::string& path);

}  // namespace inhabit::inbetween
