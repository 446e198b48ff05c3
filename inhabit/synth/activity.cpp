#include "inhabit/synth/activity.h"

#include <torch/types.h>

#include <algorithm>
#include <cmath>

#include "inhabit/each_item.h"
#include "inhabit/error.h"
#include "inhabit/math/rotation.h"

namespace inhabit {
namespace {

using torch::Tensor;

/// Central differences over 2 * half frames: of (T, C) per second.
Tensor rate_over(const Tensor& values, int64_t half, double rate) {
  const int64_t T = values.size(0);
  const Tensor t = torch::arange(T);
  const Tensor before = (t - half).clamp(0), after = (t + half).clamp(0, T - 1);
  const Tensor span = (after - before).clamp(1).to(values.dtype()) / rate;
  return (values.index_select(0, after) - values.index_select(0, before)) / span.unsqueeze(1);
}

/// (T) mean of (T) over 2 * half + 1 frames.
Tensor mean_around(const Tensor& values, int64_t half) {
  const int64_t T = values.size(0);
  const Tensor sums = torch::cat({torch::zeros({1}, values.dtype()), values.cumsum(0)});
  const Tensor t = torch::arange(T);
  const Tensor from = (t - half).clamp(0), to = (t + half + 1).clamp(0, T);
  return (sums.index_select(0, to) - sums.index_select(0, from)) / (to - from).to(values.dtype());
}

/// Radians a second that the hips turn, from the line between them: (T). Not headings(): shoulders swing while the
/// hands are busy.
Tensor turn_rate(const Tensor& joints, int64_t half, double rate) {
  const Tensor left = joints.select(1, 1) - joints.select(1, 2);
  Tensor yaw = yaw_of_left(left);
  const Tensor step = torch::remainder(torch::diff(yaw) + M_PI, 2 * M_PI) - M_PI;
  yaw = torch::cat({yaw.slice(0, 0, 1), yaw[0] + step.cumsum(0)});
  return rate_over(yaw.unsqueeze(1), half, rate).select(1, 0).abs();
}

void add_to(Dynamics& sum, const Dynamics& one) {
  const auto weight = static_cast<double>(one.frames);
  sum.frames += one.frames;
  sum.speed += weight * one.speed;
  sum.acceleration += weight * one.acceleration;
  sum.jerk += weight * one.jerk;
}

void divide(Dynamics& sum) {
  if (sum.frames == 0) return;
  const auto n = static_cast<double>(sum.frames);
  sum.speed /= n, sum.acceleration /= n, sum.jerk /= n;
}

}  // namespace

Tensor activities(const Clip& clip) {
  const Tensor joints = clip.joints.to(torch::kDouble);
  if (clip.frames() < 2) return torch::zeros({clip.frames()}, torch::kInt64);
  const auto half = static_cast<int64_t>(std::lround(clip.rate / 4));
  const Tensor root = joints.select(1, 0);
  const double leg = ((joints[0][1] - joints[0][4]).norm() + (joints[0][4] - joints[0][7]).norm()).item<double>();
  const Tensor rates = rate_over(root, half, clip.rate);
  const Tensor speed = rates.index_select(1, torch::tensor({0, 2})).norm(2, 1), rises = rates.select(1, 1);
  const Tensor low = root.select(1, 1) < 0.75 * leg;
  const Tensor wrists = joints.slice(1, 20, 22) - root.unsqueeze(1);
  const Tensor steps = torch::diff(wrists, 1, 0).norm(2, 2).amax(1) * clip.rate;
  const Tensor moves = torch::cat({steps, steps.slice(0, -1)});
  const Tensor hands = mean_around(moves, half);
  const Tensor turning = turn_rate(joints, half, clip.rate);
  Tensor out = torch::full({clip.frames()}, static_cast<int64_t>(Activity::stand), torch::kInt64);
  const auto set = [&](Activity activity, const Tensor& where) {
    out.masked_fill_(where, static_cast<int64_t>(activity));
  };
  set(Activity::still, (hands < 0.08) & (speed < 0.08));
  set(Activity::gesture, hands > 0.3);
  set(Activity::turn, turning > 0.6);
  set(Activity::walk, speed > 0.35);
  set(Activity::run, speed > 2.0);
  set(Activity::sit, low & (speed < 0.35) & (rises.abs() < 0.15));
  set(Activity::sit_down, (rises < -0.2) & (speed < 0.8) & (root.select(1, 1) < 1.05 * leg));
  set(Activity::stand_up, (rises > 0.2) & (speed < 0.8) & (root.select(1, 1) < 1.05 * leg));
  set(Activity::other, low & (root.select(1, 1) < 0.35));  // on the floor
  return out;
}

Tensor low_passed(const Clip& clip, double cutoff) {
  if (!(cutoff > 0 && cutoff < clip.rate / 2)) throw Error("the low-pass", "is not between 0 Hz and half the rate");
  const double sigma = std::sqrt(std::log(2.0)) / (2 * M_PI * cutoff) * clip.rate;  // frames
  const auto reach = std::min<int64_t>(static_cast<int64_t>(std::ceil(4 * sigma)), clip.frames() - 1);
  const Tensor at = torch::arange(-reach, reach + 1, torch::kDouble);
  Tensor weights = torch::exp(-at.square() / (2 * sigma * sigma));
  weights /= weights.sum();
  const int64_t T = clip.frames();
  const Tensor joints = clip.joints.to(torch::kDouble);
  Tensor out = torch::zeros_like(joints);
  for (int64_t k = -reach; k <= reach; ++k)  // the ends are held
    out += weights[k + reach] * joints.index_select(0, (torch::arange(T) + k).clamp(0, T - 1));
  return out;
}

std::array<ActivityDynamics, kActivityNames.size()> dynamics_by_activity(const Dataset& dataset,
                                                                         const std::string& split, double cutoff) {
  std::array<ActivityDynamics, kActivityNames.size()> out;
  const std::vector<DatasetClip> clips = dataset.split(split);
  each_item(static_cast<int64_t>(clips.size()), {}, [&](int64_t i) {
    const Clip clip = load_clip(dataset, clips[static_cast<size_t>(i)]);
    const Tensor doing = activities(clip);
    Clip smooth = clip;
    smooth.joints = low_passed(clip, cutoff);
    for (size_t a = 0; a < out.size(); ++a) {
      const Tensor mask = doing == static_cast<int64_t>(a);
      const Dynamics raw = dynamics(clip, mask), passed = dynamics(smooth, mask);
#pragma omp critical(inhabit_activity)
      {
        add_to(out[a].raw, raw);
        add_to(out[a].smooth, passed);
      }
    }
  });
  for (ActivityDynamics& one : out) divide(one.raw), divide(one.smooth);
  return out;
}

ScoreTable activity_table(const std::array<ActivityDynamics, kActivityNames.size()>& by_activity) {
  ScoreTable table;
  table.labels = {""};
  table.columns = {{"", "frames", "frames", 0},
                   {"", "m/s", "speed", 2},
                   {"", "m/s^2", "acceleration", 2},
                   {"", "m/s^3", "jerk", 1},
                   {"", "low m/s^2", "low_acceleration", 2},
                   {"", "low m/s^3", "low_jerk", 1}};
  for (size_t a = 0; a < by_activity.size(); ++a) {
    const auto& [raw, smooth] = by_activity[a];
    if (raw.frames == 0) continue;
    table.rows.push_back({{kActivityNames[a]},
                          {{static_cast<double>(raw.frames)},
                           {raw.speed},
                           {raw.acceleration},
                           {raw.jerk},
                           {smooth.acceleration},
                           {smooth.jerk}}});
  }
  return table;
}

}  // namespace inhabit
