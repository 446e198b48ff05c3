#pragma once
#include "inhabit/inbetween/model_file.h"
#include "inhabit/train/loop.h"
#include "inhabit/train/stages.h"

namespace inhabit::inbetween {

/// What the training of `networks.network` is, whichever motion it makes: its weights, settings and how they are
/// averaged. Batches, losses and validation are left to be set.
/// @param samples in an epoch
TrainTask denoiser_task(const Networks& networks, const TrainRun& run, int64_t samples);

}  // namespace inhabit::inbetween
