#pragma once
#include <cmath>
#include <cstdint>
#include <random>

namespace inhabit {

// Draws that give the same numbers with every standard library (std:: distributions do not).

/// Uniform in [low, high).
inline double uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random() >> 11) * 0x1.0p-53);
}

/// A whole number in [low, high], both included.
inline int uniform_int(std::mt19937_64& random, int low, int high) {
  return low + static_cast<int>(random() % static_cast<uint64_t>(high - low + 1));
}

/// True with probability p.
inline bool chance(std::mt19937_64& random, double p) { return uniform(random, 0, 1) < p; }

/// Normal with the given mean and deviation (Box and Muller; two draws each time).
inline double normal(std::mt19937_64& random, double mean = 0, double deviation = 1) {
  const double u = uniform(random, 0x1.0p-53, 1), v = uniform(random, 0, 1);
  return mean + deviation * std::sqrt(-2 * std::log(u)) * std::cos(6.283185307179586 * v);
}

/// The seed of item `index` of a stream seeded with `seed`, so that items can be made in any order (SplitMix64's
/// mixing).
inline uint64_t item_seed(uint64_t seed, uint64_t index) {
  uint64_t z = seed + 0x9e3779b97f4a7c15ULL * (index + 1);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace inhabit
