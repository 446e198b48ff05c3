#pragma once
#include "inhabit/inbetween/config.h"
#include "inhabit/train/stages.h"

namespace inhabit::inbetween {

/// Trains the denoiser of residual motion, stage "denoiser". Each step draws windows anew: `recorded` of them recorded
/// motion, every second one mirrored, their keys far apart or as in the paper, obstacles in the way of the baseline in
/// `blocked` of them. Returns false when it was interrupted.
bool train_residual(const TrainRun& run, const Config& config);

}  // namespace inhabit::inbetween
