#pragma once
#include <array>
#include <random>
#include <vector>

namespace inhabit {

/// Minimum-jerk step from 0 at u <= 0 to 1 at u >= 1 (Flash & Hogan 1985): velocity and acceleration vanish at both
/// ends.
double minimum_jerk(double u);

/// Rises from 0 between `rise` and `full`, stays 1, falls back to 0 between `fall` and `end`. Seconds.
struct Envelope {
  double rise = 0;            ///< leaves 0
  double full = 0;            ///< reaches 1
  double fall = 0;            ///< leaves 1
  double end = 0;             ///< reaches 0
  double at(double t) const;  ///< 0 to 1
};

/// Hermite cubic through (t, value) keys with monotone slopes (Fritsch & Carlson 1980), constant beyond the ends.
class KeyCurve {
 public:
  void add(double t, double value);  ///< Keys come in rising time; one at or before the last key's time is left out.
  double at(double t) const;         ///< The value there; 0 without keys.
  /// Whether there is no key.
  bool empty() const { return times_.empty(); }

 private:
  std::vector<double> times_, values_;
};

/// Zero-phase Gaussian smoothing of a track, ends repeated. @param sigma in frames.
std::vector<double> smoothed(const std::vector<double>& track, double sigma);

/// Slow wandering of about unit deviation: a sum of sinusoids between `low` and `high` Hz.
class Wander {
 public:
  /// Frequencies and phases are drawn.
  Wander(std::mt19937_64& random, double low, double high);
  double at(double t) const;  ///< at `t` seconds

 private:
  std::array<double, 4> frequency_{}, phase_{}, amplitude_{};
};

}  // namespace inhabit
