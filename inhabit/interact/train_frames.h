#pragma once
#include "inhabit/interact/predictor.h"
#include "inhabit/interact/training.h"
#include "inhabit/train/loop.h"

namespace inhabit::interact {

/// The stage in which a predictor is trained on its own rollouts.
std::string rollout_stage(Predictor predictor);

/// The task of a stage that trains a predictor on single frames of recordings (Eq. 3), or on rows of its own rollouts.
/// Rollouts go on from the stage before them, or from `start`. `t` must outlive the task.
/// @param from the file that `start` is of, in errors.
TrainTask frame_task(Predictor predictor, bool rollouts, Training& t, const Networks& start, const std::string& from);

}  // namespace inhabit::interact
