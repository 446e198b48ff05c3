#include "inhabit/refine/noise.h"

#include <ATen/Parallel.h>

#include <cmath>
#include <limits>

#include "inhabit/math/quantile.h"
#include "inhabit/math/quaternion.h"

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;

constexpr double kLongest = 256;  // differences in a piece of which a periodogram is taken
constexpr double kQuiet = 0.55;   // from this part of the highest frequency on there is noise alone

/// Third differences at each frequency: what noise of a unit gives, and what is there, in the mean of the components.
struct Spectrum {
  std::vector<double> of_unit, power;
};

/// Adds the periodogram of differences [first, last) under a Hann window, frequency 0 left out.
void add_periodogram(const Track& z, size_t first, size_t last, Spectrum& to) {
  const size_t count = last - first;
  const auto whole = static_cast<double>(count);
  std::vector<double> cosines, sines, window;
  double weight = 0;
  for (size_t i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * static_cast<double>(i) / whole;
    cosines.push_back(std::cos(angle));
    sines.push_back(std::sin(angle));
    window.push_back(1 - std::cos(angle + M_PI / whole));
    weight += window.back() * window.back();
  }
  for (size_t k = 1; k <= count / 2; ++k) {
    Vector3d real = Vector3d::Zero(), imaginary = Vector3d::Zero();
    for (size_t t = 0, i = 0; t < count; ++t, i = (i + k) % count) {
      real += cosines[i] * window[t] * z[first + t];
      imaginary += sines[i] * window[t] * z[first + t];
    }
    to.of_unit.push_back(std::pow(2 * std::sin(M_PI * static_cast<double>(k) / whole), 6));
    to.power.push_back((real.squaredNorm() + imaginary.squaredNorm()) / (3 * weight));
  }
}

Track third_differences(const Track& track) {
  Track out;
  for (size_t t = 0; t + 3 < track.size(); ++t)
    out.push_back(track[t + 3] - 3 * track[t + 2] + 3 * track[t + 1] - track[t]);
  return out;
}

}  // namespace

Level level_of(const Track& z, double rate) {
  if (z.size() < 2) return {};
  const auto pieces = static_cast<size_t>(std::ceil(static_cast<double>(z.size()) / kLongest));
  Spectrum seen;
  for (size_t i = 0; i < pieces; ++i) add_periodogram(z, i * z.size() / pieces, (i + 1) * z.size() / pieces, seen);
  const double high = std::pow(2 * std::sin(M_PI / 2 * kQuiet), 6);
  double noise = 0, quiet = 0;
  for (size_t k = 0; k < seen.power.size(); ++k) {
    if (seen.of_unit[k] < high) continue;
    noise += seen.power[k] / seen.of_unit[k];
    ++quiet;
  }
  if (noise <= 0) return {};
  noise /= quiet;  // variance
  // Smoothing with white jerk of variance q leaves q / (q + n) of each frequency. Its risk is known but for a constant.
  Level best{std::sqrt(noise), 0};
  double least = std::numeric_limits<double>::infinity();
  for (double log_ratio = -6; log_ratio <= 3; log_ratio += 0.125) {
    const double q = std::pow(10, log_ratio) * noise;
    double risk = 0;
    for (size_t k = 0; k < seen.power.size(); ++k) {
      const double n = noise * seen.of_unit[k];
      risk += n * seen.power[k] / ((q + n) * (q + n)) + 2 * q / (q + n);
    }
    if (risk >= least) continue;
    least = risk;
    best.jerk = std::sqrt(q) * rate * rate * rate;
  }
  return best;
}

double noise_of_places(const torch::Tensor& joints, double rate) {
  const torch::Tensor places = joints.to(torch::kFloat64).contiguous();
  const int64_t frames = places.size(0), count = places.size(1);
  const double* data = places.data_ptr<double>();
  std::vector<double> noises;
  for (int64_t j = 0; j < count; ++j) {
    Track track;
    for (int64_t t = 0; t < frames; ++t) track.emplace_back(Eigen::Map<const Vector3d>(data + 3 * (t * count + j)));
    noises.push_back(level_of(third_differences(track), rate).noise);
  }
  return median(std::move(noises));
}

Levels levels_of(const Bones& bones, const Trajectory& trajectory, double rate) {
  Levels out;
  const Poses poses = posed(bones, trajectory);
  const size_t joints = trajectory.front().local.size();
  std::vector<double> noises(joints), jerks(joints);
  out.rotations.resize(joints);
#pragma omp parallel for num_threads(at::get_num_threads()) schedule(dynamic)
  for (size_t j = 0; j < joints; ++j) {
    Track steps, bends;  // third differences of a rotation are second ones of its steps
    for (size_t t = 0; t + 1 < trajectory.size(); ++t)
      steps.push_back(axis_angle_of(trajectory[t].local[j].conjugate() * trajectory[t + 1].local[j]));
    for (size_t t = 0; t + 2 < steps.size(); ++t) bends.push_back(steps[t + 2] - 2 * steps[t + 1] + steps[t]);
    out.rotations[j] = level_of(bends, rate).noise;
    const Level place = level_of(third_differences(track_of(poses, static_cast<int>(j))), rate);
    noises[j] = place.noise;
    jerks[j] = place.jerk;
  }
  out.place = median(std::move(noises));
  out.jerk = median(std::move(jerks));
  Track root;
  for (const FramePose& pose : trajectory) root.push_back(pose.trans);
  out.root = level_of(third_differences(root), rate).noise;
  return out;
}

}  // namespace inhabit::refine
