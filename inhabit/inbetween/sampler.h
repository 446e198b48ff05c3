#pragma once
#include <torch/types.h>

#include <functional>
#include <vector>

#include "inhabit/inbetween/schedule.h"

namespace inhabit::inbetween {

/// What of a clip is given, in standardised features.
struct GivenFeatures {
  torch::Tensor values;       ///< (B, F, T)
  torch::Tensor mask;         ///< (B, F, T), 1 where `values` hold, else 0
  int64_t t_star = 0;         ///< T*: they hold at steps t >= T* only,
  torch::Tensor always = {};  ///< (B, F, T), but where this is 1 at every step; undefined: at the clip's two ends
  int64_t lead = 1;  ///< frames from what holds at every step to the first that it does not move; 1: none is moved, 0:
                     ///< not even the given ones, so that what the samples miss them by can be seen
};

/// Where what is given holds at every step (B, F, T).
torch::Tensor held_places(const GivenFeatures& given);

/// x' = m s + (1 - m) x_t (3.2, 3.2.1). @param x (B, F, T). @param steps (B) int64
torch::Tensor impute(const torch::Tensor& x, const GivenFeatures& given, const torch::Tensor& steps);

/// Where between given frames each place of a mask (B, F, T) lies.
struct GivenNeighbours {
  torch::Tensor before,
      after;            ///< (B, F, T) int64: the given frames around it, one twice beyond the first and the last
  torch::Tensor share;  ///< (B, F, T) in [0, 1], how far from the one to the other
};
GivenNeighbours given_neighbours(const torch::Tensor& mask);

/// Each feature of each clip between the frames that give it, on straight lines, and held before the first and behind
/// the last: (B, F, T). A feature that no frame gives is 0.
torch::Tensor interpolate_given(const GivenFeatures& given);

/// How much of a correction in the places set in a mask (B, F, T) each place takes: 1 in them, smoothly less with the
/// frames to the nearest, none from `lead` on.
torch::Tensor lead_share(const torch::Tensor& mask, int64_t lead);

/// With t_star > 0, `found` (B, F, T) moved, all frames alike, by what it misses the noisy keys by in the mean.
torch::Tensor nearer_to_noisy_keys(const torch::Tensor& found, const GivenFeatures& given);

/// What is given in the places where it holds at every step; the frames around them are moved along by what the
/// prediction missed it by, less and less. With t_star > 0 all frames are moved first by what the prediction misses the
/// noisy keys by in the mean. With lead = 1 nothing is moved. @param found (B, F, T)
torch::Tensor lead_to_given(const torch::Tensor& found, const GivenFeatures& given);

enum class Sampler {
  ddpm,       ///< ancestral: draws from the posterior of every step
  ddim,       ///< Song et al. 2021, eta 0
  dpm_solver  ///< DPM-Solver++ (2M), Lu et al. 2022: second order, data prediction
};

/// The steps, falling, that `count` evaluations out of `total` are spent on: evenly spread, from the noisiest on. Where
/// t_star > 0, one of them at least, where there are two, is below it, so that keys are denoised too.
std::vector<int64_t> sampling_steps(int64_t total, int64_t count, int64_t t_star);

/// The clean clip (B, F, T) from an imputed x_t and its step.
using Denoise = std::function<torch::Tensor(const torch::Tensor& x, int64_t t)>;
/// Normal noise (B, F, T). Of n evaluations, x_T is number n - 1, and what is drawn behind evaluation i (n - 1 the
/// first, 1 the last but one) is number i - 1; only ddpm asks for the latter.
using NoiseSource = std::function<torch::Tensor(int64_t number)>;

/// Numbers that depend on seed, place in the batch and number alone.
NoiseSource seeded_noise(int64_t batch, int64_t features, int64_t frames, uint64_t seed);

/// Clips (B, F, T) by `count` evaluations. What is given holds in the result too: all of it where t_star is 0, else at
/// the ends. @param progress called behind every evaluation with how many are done; may be empty
torch::Tensor sample(const DiffusionSchedule& schedule, Sampler sampler, int64_t count, const Denoise& denoise,
                     const GivenFeatures& given, const NoiseSource& noise,
                     const std::function<void(int64_t)>& progress = {});

}  // namespace inhabit::inbetween
