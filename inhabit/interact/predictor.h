#pragma once
#include <torch/types.h>

#include <string>
#include <vector>

#include "inhabit/interact/layout.h"

namespace inhabit::interact {

/// What predicts the next frame: PoseNet, which ControlNet plans hands for, or what it is compared with: NSM (Starke et
/// al. 2019) and SAMP (Hassan et al. 2021), both without contacts and with them among the goals (sec. 5.1).
enum class Predictor { pose, nsm, nsm_control, samp, samp_control };

/// All predictors, in the order of the enumeration.
inline const std::vector<Predictor> kPredictors = {Predictor::pose, Predictor::nsm, Predictor::nsm_control,
                                                   Predictor::samp, Predictor::samp_control};

/// As stages of training and prefixes in model files have it: "pose", "nsm_control".
std::string name_of(Predictor predictor);
/// As tables have it: "ours", "NSM + Control".
std::string title_of(Predictor predictor);

/// PoseNet's rows, standardised, as a predictor takes them.
/// @param input (B, 4344). @param contacts (B, 8), build_contacts().
/// @return what NSM and SAMP see has no control in it, and contacts, if any, after the goals.
torch::Tensor rows_for(Predictor predictor, const InputLayout& layout, const torch::Tensor& input,
                       const torch::Tensor& contacts);

}  // namespace inhabit::interact
