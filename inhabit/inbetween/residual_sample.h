#pragma once
#include <functional>

#include "inhabit/inbetween/baseline.h"
#include "inhabit/inbetween/fast_denoiser.h"
#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/sampler.h"
#include "inhabit/inbetween/scene_probe.h"

namespace inhabit::inbetween {

/// How the residual motion of a window is sampled.
struct ResidualSampling {
  const DiffusionSchedule& schedule;
  Sampler sampler = Sampler::dpm_solver;
  int64_t steps = 1;       ///< evaluations of the denoiser
  double guidance = 1;     ///< w D(scene) + (1 - w) D(no scene); at 0 the scene is not looked at
  NoiseSource noise = {};  ///< (1, 135, T)
  std::function<void(int64_t done)> progress = {};  ///< may be empty
};

/// A window's motion as it was sampled.
struct SampledMotion {
  Poses poses;  ///< of all its frames
  torch::Tensor
      feet;  ///< (T, 4) probabilities that feet are in contact, of a model with FootContactNet; else undefined
};

/// Motion of a window between its keys: a sample of the residual on the baseline. At each step the denoiser sees what
/// it predicted before and the scene around that. Whole keys come out as they are; frames behind the last repeat it.
/// @param denoiser of `networks`. @param scene the baseline's floor at height 0
SampledMotion sample_residual(const Networks& networks, FastDenoiser& denoiser, const Baseline& baseline,
                              const SceneDistances& scene, const ResidualSampling& how);

}  // namespace inhabit::inbetween
