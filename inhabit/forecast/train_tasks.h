#pragma once
#include <string>

#include "inhabit/forecast/baselines.h"
#include "inhabit/forecast/model_file.h"
#include "inhabit/forecast/sample.h"
#include "inhabit/train/loop.h"

namespace inhabit::forecast {

// What the stages of train() minimise, and what they validate by. `model` holds the networks that are trained and those
// whose predictions are taken; it and both data sets outlive the task.

/// The contact network: squared error of the maps' DCT (Eq. 7).
TrainTask contact_task(Networks& model, const Data& data, const Data& validation, torch::Device device);

/// The paper's motion network (Eq. 10-13). @param stage "motion", "no_contact" or "adapt"
TrainTask motion_task(const std::string& stage, Networks& model, const Data& data, const Data& validation,
                      torch::Device device);

/// The articulated network: true, predicted and no contact points from the start. Validates with predicted ones.
TrainTask articulated_task(Networks& model, const Data& data, const Data& validation, torch::Device device);

/// Hypotheses: the nearest of them is drawn to what happens, and said to be likely; the others by a little, so that
/// none is left behind. Contact points are predicted ones. Validates by the error of the nearest.
TrainTask hypotheses_task(Networks& model, const Data& data, const Data& validation, torch::Device device);

/// A baseline: mean joint error in the world. Validates by the same. `config` must outlive the task.
TrainTask baseline_task(const Baseline& baseline, const Config& config, const Data& data, const Data& validation,
                        torch::Device device);

/// The same of SLT* but for its losses: mean absolute errors of the goal, the pose there, the path and the poses.
/// @param network of the baseline
TrainTask slt_task(const Baseline& baseline, SltNetwork network, const Config& config, const Data& data,
                   const Data& validation, torch::Device device);

}  // namespace inhabit::forecast
