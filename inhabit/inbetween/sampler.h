#pragma once
#include <torch/types.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "inhabit/inbetween/schedule.h"

namespace inhabit::inbetween {

/// The hard constraints of a clip: features whose values are known, standardised.
struct KeyConstraints {
  torch::Tensor values;       ///< (B, F, T)
  torch::Tensor mask;         ///< (B, F, T), 1 where a value is known, else 0
  int64_t t_star = 0;         ///< T*: values are imputed at diffusion steps t >= T* only (0: at all steps)
  torch::Tensor always = {};  ///< (B, F, T), 1 where a value is imputed at every step whatever T* is; undefined: in the
                              ///< clip's first and last frame
  bool imposed = true;  ///< a sample meets them; else it is what the network says, so that the residual can be seen
};

/// Mask of the constraints that are imputed at every step (B, F, T).
torch::Tensor hard_constraints(const KeyConstraints& constraints);

/// Imputation: x' = m s + (1 - m) x_t (3.2, 3.2.1), s the values, m the mask at these steps.
/// @param x (B, F, T). @param steps (B) int64
torch::Tensor impute(const torch::Tensor& x, const KeyConstraints& constraints, const torch::Tensor& steps);

/// For each entry of a mask (B, F, T) the constrained frames before and after it.
struct KeyNeighbours {
  torch::Tensor before;  ///< (B, F, T) int64 frame, constrained, at or before this one; the first where none is
  torch::Tensor after;   ///< (B, F, T) int64 frame, constrained, at or after this one; the last where none is
  torch::Tensor weight;  ///< (B, F, T) interpolation weight in [0, 1]: 0 at `before`, 1 at `after`
};
/// The constrained frames around each frame, of a mask (B, F, T) that is 1 where a feature is constrained.
KeyNeighbours key_neighbours(const torch::Tensor& mask);

/// The interpolated baseline (B, F, T): each feature linear between the frames that constrain it, constant before the
/// first and after the last. A feature that no frame constrains is 0.
torch::Tensor interpolate_keys(const KeyConstraints& constraints);

/// How a denoiser's steps are taken, from noise to motion.
enum class Sampler {
  ddpm,       ///< ancestral: draws from the posterior of every step
  ddim,       ///< Song et al. 2021, eta 0
  dpm_solver  ///< DPM-Solver++ (2M), Lu et al. 2022: second order, data prediction
};
/// What users call them: ddpm, ddim and dpm.
const std::map<std::string, Sampler>& samplers_by_name();

/// The diffusion steps at which the denoiser is evaluated: `count` of `total`, evenly spread, the noisiest first. With
/// t_star > 0 and two evaluations or more, at least one is below t_star, so that the keys are denoised too.
std::vector<int64_t> sampling_steps(int64_t total, int64_t count, int64_t t_star);

/// The clean clip (B, F, T) from an imputed x_t and its step.
using Denoise = std::function<torch::Tensor(const torch::Tensor& x, int64_t t)>;
/// Normal noise (B, F, T) by number. With n evaluations, number n - 1 is x_T. DDPM also draws after every evaluation
/// but the last: number n - 2 after the first, down to number 0.
using NoiseSource = std::function<torch::Tensor(int64_t number)>;

/// Noise that depends on the seed, the index in the batch and the number alone.
NoiseSource seeded_noise(int64_t batch, int64_t features, int64_t frames, uint64_t seed);

/// The same noise with its slow part, the first four coefficients of its DCT over the frames (in four seconds what is
/// slower than 0.4 Hz), scaled by `temperature`. It decides the course of a motion, what is quicker how lively it
/// is: at 0 a sample takes the likeliest course, at 1 it is one of all that the network has learned.
NoiseSource with_temperature(NoiseSource noise, double temperature);

/// Samples clips (B, F, T) with `count` evaluations. The result meets the hard constraints: all of them where t_star is
/// 0, else those imputed at every step; none where `imposed` is false. @param progress called after each evaluation
/// with the number done; may be empty
torch::Tensor sample(const DiffusionSchedule& schedule, Sampler sampler, int64_t count, const Denoise& denoise,
                     const KeyConstraints& constraints, const NoiseSource& noise,
                     const std::function<void(int64_t)>& progress = {});

}  // namespace inhabit::inbetween
