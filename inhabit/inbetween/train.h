#pragma once
#include "inhabit/inbetween/config.h"
#include "inhabit/train/stages.h"

namespace inhabit::inbetween {

/// Trains the denoiser (3.2), stage "denoiser": one denoising step a sample, t drawn uniformly, key frames drawn at
/// random, always with the first and the last. Noise-aware where config.t_star > 0: key frames are noisy then and
/// imputed for t >= t_star alone. `run.from` may be a network that sees more (ablations). Returns false when it was
/// interrupted.
bool train(const TrainRun& run, const Config& config);

/// Trains the motion features that the Frechet distance is taken over, on the same windows; steps, batch, rate and
/// stride of config.training count. Returns false when it was interrupted.
bool train_motion_features(const TrainRun& run, const Config& config);

}  // namespace inhabit::inbetween
