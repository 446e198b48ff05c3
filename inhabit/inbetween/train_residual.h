#pragma once
#include "inhabit/inbetween/config.h"
#include "inhabit/train/stages.h"

namespace inhabit::inbetween {

/// Trains the denoiser of residual motion: stage "denoiser" by diffusion, then stage "deployed" as it is sampled in use
/// (residual_losses.h). Stages that are left out are those of `run.from`. Returns false when it was interrupted.
bool train_residual(const TrainRun& run, const Config& config);

}  // namespace inhabit::inbetween
