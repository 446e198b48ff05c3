#pragma once
#include "inhabit/interact/config.h"
#include "inhabit/train/stages.h"

namespace inhabit::interact {

/// Trains "pose" (PoseNet, Eq. 3: mean squared error of standardised numbers), "control" (ControlNet, Eq. 2) and
/// "contact" (ContactNet, Eq. 4) on native data sets of people who sit down; and, where they are asked for, what
/// PoseNet is compared with on the same rows: "nsm", "nsm_control", "samp" and "samp_control". "rollout" and each of
/// these with "_rollout" behind its name go on with rows of the network's own motion (rollout.h). Returns false when it
/// was interrupted.
bool train(const TrainRun& run, const Config& config);

}  // namespace inhabit::interact
