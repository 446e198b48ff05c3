#include "inhabit/synth/curves.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/random.h"

namespace inhabit {

double minimum_jerk(double u) {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * u * (10.0 + u * (-15.0 + 6.0 * u));
}

double Envelope::at(double t) const {
  if (t <= rise || t >= end) return 0.0;
  if (t < full) return minimum_jerk((t - rise) / (full - rise));
  if (t <= fall) return 1.0;
  return 1.0 - minimum_jerk((t - fall) / (end - fall));
}

void KeyCurve::add(double t, double value) {
  if (!times_.empty() && t <= times_.back() + 1e-6) return;
  times_.push_back(t);
  values_.push_back(value);
}

double KeyCurve::at(double t) const {
  if (times_.empty()) return 0.0;
  if (t <= times_.front()) return values_.front();
  if (t >= times_.back()) return values_.back();
  const size_t k = static_cast<size_t>(std::upper_bound(times_.begin(), times_.end(), t) - times_.begin()) - 1;
  auto chord = [&](size_t i) { return (values_[i + 1] - values_[i]) / (times_[i + 1] - times_[i]); };
  auto slope = [&](size_t i) {
    if (i == 0 || i + 1 == times_.size()) return 0.0;
    const double before = chord(i - 1), after = chord(i);
    if (before * after <= 0) return 0.0;
    const double h0 = times_[i] - times_[i - 1], h1 = times_[i + 1] - times_[i];
    return 3.0 * (h0 + h1) / ((2 * h1 + h0) / before + (h1 + 2 * h0) / after);
  };
  const double h = times_[k + 1] - times_[k], u = (t - times_[k]) / h;
  const double u2 = u * u, u3 = u2 * u;
  return (2 * u3 - 3 * u2 + 1) * values_[k] + (u3 - 2 * u2 + u) * h * slope(k) + (3 * u2 - 2 * u3) * values_[k + 1] +
         (u3 - u2) * h * slope(k + 1);
}

std::vector<double> smoothed(const std::vector<double>& track, double sigma) {
  if (sigma <= 0 || track.empty()) return track;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  std::vector<double> kernel(radius + 1);
  double total = 0;
  for (int i = 0; i <= radius; ++i) {
    kernel[i] = std::exp(-0.5 * i * i / (sigma * sigma));
    total += (i == 0 ? 1 : 2) * kernel[i];
  }
  for (double& k : kernel) k /= total;
  const int n = static_cast<int>(track.size());
  std::vector<double> out(track.size());
  for (int t = 0; t < n; ++t) {
    double sum = kernel[0] * track[t];
    for (int i = 1; i <= radius; ++i) sum += kernel[i] * (track[std::max(t - i, 0)] + track[std::min(t + i, n - 1)]);
    out[t] = sum;
  }
  return out;
}

Wander::Wander(std::mt19937_64& random, double low, double high) {
  double power = 0;
  for (size_t i = 0; i < frequency_.size(); ++i) {
    const double u = (static_cast<double>(i) + uniform(random, 0, 1)) / static_cast<double>(frequency_.size());
    frequency_[i] = low * std::pow(high / low, u);
    phase_[i] = 6.283185307179586 * uniform(random, 0, 1);
    amplitude_[i] = 1.0 / std::sqrt(frequency_[i] / low);
    power += 0.5 * amplitude_[i] * amplitude_[i];
  }
  for (double& a : amplitude_) a /= std::sqrt(power);
}

double Wander::at(double t) const {
  double sum = 0;
  for (size_t i = 0; i < frequency_.size(); ++i)
    sum += amplitude_[i] * std::sin(6.283185307179586 * frequency_[i] * t + phase_[i]);
  return sum;
}

}  // namespace inhabit
