#include "inhabit/inbetween/sampler.h"

#include <torch/torch.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "inhabit/error.h"
#include "inhabit/math/dct.h"
#include "inhabit/math/random.h"

namespace inhabit::inbetween {

using torch::Tensor;

namespace {

/// 0 to T - 1 of a mask (B, F, T), on its device; int64.
Tensor frame_numbers(const Tensor& mask) { return torch::arange(mask.size(2), mask.options().dtype(torch::kInt64)); }

/// For every entry of a mask (B, F, T) the frame of the last set entry up to it (-1: none) and of the next from it on
/// (T: none); int64.
std::pair<Tensor, Tensor> nearest_set(const Tensor& mask) {
  const int64_t frames = mask.size(2);
  const Tensor here = frame_numbers(mask).expand(mask.sizes()), set = mask > 0;
  const Tensor none_before = torch::full({}, -1, torch::kInt64), none_after = torch::full({}, frames, torch::kInt64);
  return {std::get<0>(torch::where(set, here, none_before).cummax(2)),
          std::get<0>(torch::where(set, here, none_after).flip(2).cummin(2)).flip(2)};
}

}  // namespace

Tensor hard_constraints(const KeyConstraints& constraints) {
  if (constraints.t_star == 0) return constraints.mask;
  if (constraints.always.defined()) return constraints.always;
  Tensor ends = torch::zeros_like(constraints.mask);
  for (const int64_t end : {int64_t{0}, ends.size(2) - 1}) ends.select(2, end).copy_(constraints.mask.select(2, end));
  return ends;
}

Tensor impute(const Tensor& x, const KeyConstraints& constraints, const Tensor& steps) {
  const Tensor inside = (steps >= constraints.t_star).to(x.scalar_type()).view({-1, 1, 1});
  return torch::where(torch::maximum(constraints.mask * inside, hard_constraints(constraints)) > 0, constraints.values,
                      x);
}

KeyNeighbours key_neighbours(const Tensor& mask) {
  const int64_t frames = mask.size(2);
  const auto [last, next] = nearest_set(mask);
  const Tensor before = torch::where(last < 0, next, last).clamp(0, frames - 1),
               after = torch::where(next >= frames, last, next).clamp(0, frames - 1);
  return {before, after, (frame_numbers(mask) - before).to(torch::kFloat32) / (after - before).clamp_min(1)};
}

Tensor interpolate_keys(const KeyConstraints& constraints) {
  const auto [before, after, weight] = key_neighbours(constraints.mask);
  const Tensor from = constraints.values.gather(2, before), to = constraints.values.gather(2, after);
  return torch::where((constraints.mask > 0).any(2, true), torch::lerp(from, to, weight), torch::zeros({}));
}

const std::map<std::string, Sampler>& samplers_by_name() {
  static const std::map<std::string, Sampler> all = {
      {"ddpm", Sampler::ddpm}, {"ddim", Sampler::ddim}, {"dpm", Sampler::dpm_solver}};
  return all;
}

std::vector<int64_t> sampling_steps(int64_t total, int64_t count, int64_t t_star) {
  if (count < 1 || count > total)
    throw Error("sampling steps", std::to_string(count) + " is not within 1 and " + std::to_string(total));
  std::vector<int64_t> steps;
  for (int64_t i = count; i >= 1; --i) steps.push_back(i * total / count - 1);
  if (count > 1 && t_star > 0 && steps.back() >= t_star) steps.back() = t_star - 1;
  return steps;
}

NoiseSource seeded_noise(int64_t batch, int64_t features, int64_t frames, uint64_t seed) {
  return [=](int64_t number) {
    Tensor out = torch::empty({batch, features, frames});
    float* z = out.data_ptr<float>();
    for (int64_t b = 0; b < batch; ++b) {
      std::mt19937_64 random(item_seed(item_seed(seed, static_cast<uint64_t>(b)), static_cast<uint64_t>(number)));
      for (int64_t i = 0; i < features * frames; ++i) *z++ = static_cast<float>(normal(random));
    }
    return out;
  };
}

NoiseSource with_temperature(NoiseSource noise, double temperature) {
  if (temperature == 1) return noise;
  return [noise = std::move(noise), temperature](int64_t number) {
    constexpr int64_t kSlow = 4;
    const Tensor drawn = noise(number), slow = dct_matrix(drawn.size(2), std::min<int64_t>(kSlow, drawn.size(2)));
    return drawn - (1 - temperature) * drawn.matmul(slow.t()).matmul(slow);
  };
}

Tensor sample(const DiffusionSchedule& schedule, Sampler sampler, int64_t count, const Denoise& denoise,
              const KeyConstraints& constraints, const NoiseSource& noise,
              const std::function<void(int64_t)>& progress) {
  const std::vector<int64_t> steps = sampling_steps(schedule.steps(), count, constraints.t_star);
  // The schedule of the chosen steps alone, 0 the cleanest: a step of it goes to the chosen one before.
  std::vector<double> betas;
  double before = 1;
  for (auto t = steps.rbegin(); t != steps.rend(); ++t) {
    const double now = schedule.alphas_cumprod[static_cast<size_t>(*t)];
    betas.push_back(1 - now / before);
    before = now;
  }
  const DiffusionSchedule chosen = schedule_of(betas);
  const auto signal = [&](int64_t i) { return i < 0 ? 1.0 : std::sqrt(chosen.alphas_cumprod[static_cast<size_t>(i)]); };
  const auto deviation = [&](int64_t i) { return std::sqrt(std::max(0.0, 1 - signal(i) * signal(i))); };
  const auto half_log_ratio = [&](int64_t i) { return std::log(signal(i) / deviation(i)); };

  const Tensor batch_of = torch::zeros({constraints.mask.size(0)}, constraints.mask.options().dtype(torch::kInt64));
  Tensor x = noise(count - 1), clean, clean_before;
  for (int64_t i = count - 1; i >= 0; --i) {
    const int64_t t = steps[static_cast<size_t>(count - 1 - i)];
    clean = denoise(impute(x, constraints, batch_of + t), t);
    const size_t at = static_cast<size_t>(i);
    if (sampler == Sampler::ddpm) {
      x = chosen.posterior_mean_x0[at] * clean + chosen.posterior_mean_xt[at] * x;
      if (i > 0) x = x + std::sqrt(chosen.posterior_variance[at]) * noise(i - 1);
    } else {
      Tensor towards = clean;
      if (sampler == Sampler::dpm_solver && clean_before.defined() && i > 0) {
        // r: the last step's length over this one's, in half the logarithm of the signal-to-noise ratio.
        const double r = (half_log_ratio(i) - half_log_ratio(i + 1)) / (half_log_ratio(i - 1) - half_log_ratio(i));
        towards = (1 + 0.5 / r) * clean - 0.5 / r * clean_before;
      }
      const double kept = deviation(i - 1) / deviation(i);
      x = kept * x + (signal(i - 1) - kept * signal(i)) * towards;
      clean_before = clean;
    }
    if (progress) progress(count - i);
  }
  return constraints.imposed ? torch::where(hard_constraints(constraints) > 0, constraints.values, x) : x;
}

}  // namespace inhabit::inbetween
